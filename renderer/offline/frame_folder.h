// Resumable frame folder: the output of an offline run, and its sink with several encoder threads:
//
//   DIR/manifest.json      settings, frame range and machine (manifest.h)
//   DIR/frame_000000.png   and so on, each complete or absent; other files with other formats
//   (frame_format.h) DIR/frames.jsonl       one line per frame: file, camera, pose frames (output_text.h)
//
// A frame counts as done if its files are complete and it is listed. Lines are written in frame order.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/unique_fd.h"
#include "renderer/offline/frame_format.h"
#include "renderer/offline/manifest.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

// Returns the complete and listed frames of a folder with their lines (without line feed).
Result<FrameLines> listed_frames(const std::filesystem::path& folder, const Manifest& manifest,
                                 const FrameFormat& format = PngFrames());

class FrameFolder final : public sinks::FrameSink {
 public:
  // Creates or reopens the folder and keeps frames of the same run. Fails if the folder holds frames of
  // another run, or anything else if the format needs a folder of its own, or if a path element is in the
  // way.
  static Result<std::unique_ptr<FrameFolder>> open(
      const std::filesystem::path& folder, const Manifest& manifest,
      std::shared_ptr<FrameFormat> format = std::make_shared<PngFrames>());
  ~FrameFolder() override;

  bool has(uint64_t frame) const { return existing_.contains(frame); }
  uint64_t existing_frames() const { return existing_.size(); }
  // Machine that rendered the existing frames; nullopt: there are none.
  const std::optional<Machine>& machine_before() const { return machine_before_; }
  // Writes the manifest with the machine; must precede the first frame. provenance: JSON; empty: that of the
  // manifest stays.
  Result<void> begin(const Machine& machine, const std::string& provenance = {});

  Result<void> consume(sinks::FrameImage&& image) override;
  // Copies a frame from another folder, together with its line there.
  Result<void> copy(uint64_t frame, const std::filesystem::path& from_folder, const std::string& line);
  // Writes the list in frame order.
  Result<void> finish() override;
  // Lets the format complete the run if all frames of all shards are here. After finish(), or if nothing was
  // left to draw.
  Result<void> complete_run();

 private:
  FrameFolder(std::filesystem::path folder, Manifest manifest, std::shared_ptr<FrameFormat> format)
      : folder_(std::move(folder)), manifest_(std::move(manifest)), format_(std::move(format)) {}
  struct Job {
    sinks::FrameImage image;
    std::string line;
    uint64_t bytes = 0;  // of the image's pixels
    bool started = false, written = false;
  };
  void work();
  Result<void> write_files(const EncodedFrame& frame) const;
  void list_written();  // requires mutex_
  void end_threads();
  Result<void> write_list();
  Result<void> report_error();  // requires mutex_

  Result<void> lock();

  const std::filesystem::path folder_;
  UniqueFd lock_;  // excludes a second run in the same folder
  Manifest manifest_;
  const std::shared_ptr<FrameFormat> format_;
  FrameLines existing_;  // lines of existing frames
  std::optional<Machine> machine_before_;

  std::mutex ending_mutex_;  // of finish(), which several threads may call
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Job>> jobs_;  // in frame order; a line is written after all earlier ones
  uint64_t queued_bytes_ = 0;              // of jobs that are not encoded yet
  std::ofstream list_;
  FrameLines lines_;  // of this run
  bool closing_ = false;
  std::optional<Error> error_;
  bool error_reported_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace fire3dv::offline

// Resumable frame folder: the output of an offline run, and its sink with several encoder threads:
//
//   DIR/manifest.json      settings, frame range and machine (manifest.h)
//   DIR/frame_000000.png   and so on, each complete or absent
//   DIR/frames.jsonl       one line per frame: file, camera, pose frames (output_text.h)
//
// A frame counts as done if its file is complete and listed. Lines are written in frame order.
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
#include "renderer/offline/manifest.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

// Returns the complete and listed frames of a folder with their lines (without line feed).
Result<std::map<uint64_t, std::string>> listed_frames(const std::filesystem::path& folder,
                                                      const Manifest& manifest);

// Reads one listed frame with its file's bytes. Fails if the file holds another frame or size.
struct StoredFrame {
  std::vector<uint8_t> bytes;
  sinks::FrameImage image;
};
Result<StoredFrame> read_frame(const std::filesystem::path& folder, uint64_t frame, const Manifest& manifest);

class FrameFolder final : public sinks::FrameSink {
 public:
  // Creates or reopens the folder and keeps frames of the same run. Fails if the folder holds anything else,
  // or if a path element is in the way.
  static Result<std::unique_ptr<FrameFolder>> open(const std::filesystem::path& folder,
                                                   const Manifest& manifest);
  ~FrameFolder() override;

  bool has(uint64_t frame) const { return existing_.contains(frame); }
  uint64_t existing_frames() const { return existing_.size(); }
  // Machine that rendered the existing frames; nullopt: there are none.
  const std::optional<Machine>& machine_before() const { return machine_before_; }
  // Writes the manifest with the machine; must precede the first frame.
  Result<void> begin(const Machine& machine);

  Result<void> consume(sinks::FrameImage&& image) override;
  // Copies a frame from another folder, together with its line there.
  Result<void> copy(uint64_t frame, const std::filesystem::path& from_folder, const std::string& line);
  // Writes the list in frame order.
  Result<void> finish() override;

 private:
  FrameFolder(std::filesystem::path folder, Manifest manifest)
      : folder_(std::move(folder)), manifest_(std::move(manifest)) {}
  struct Job {
    sinks::FrameImage image;
    std::string line;
    bool started = false, written = false;
  };
  void work();
  void list_written();  // requires mutex_
  void end_threads();
  Result<void> write_list();
  Result<void> report_error();  // requires mutex_

  Result<void> lock();

  const std::filesystem::path folder_;
  UniqueFd lock_;  // excludes a second run in the same folder
  Manifest manifest_;
  std::map<uint64_t, std::string> existing_;  // lines of existing frames
  std::optional<Machine> machine_before_;

  std::mutex ending_mutex_;  // of finish(), which several threads may call
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Job>> jobs_;  // in frame order; a line is written after all earlier ones
  std::ofstream list_;
  std::map<uint64_t, std::string> lines_;  // of this run
  bool closing_ = false;
  std::optional<Error> error_;
  bool error_reported_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace fire3dv::offline

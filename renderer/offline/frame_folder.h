// A folder that frames are written to, and that an interrupted run goes on with:
//
//   DIR/manifest.json      what they are of (manifest.h)
//   DIR/frame_000000.png   and so on, each complete or absent
//   DIR/frames.jsonl       one line a frame: which file, which camera, which pose frames it shows
//   (frame_line.h)
//
// A frame counts when its file is whole and it is listed. Several threads encode, since that takes longer
// than drawing on a GPU; lines are written in the order of the frames.
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
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "protocol/transport/unique_fd.h"
#include "renderer/offline/manifest.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

// Of a folder: each frame that is whole and listed, with its line (without the line's end).
Result<std::map<uint64_t, std::string>> listed_frames(const std::filesystem::path& folder,
                                                      const Manifest& manifest);

// One of them, with its file's bytes. Refused when it is not what its name says: another frame, or of another
// size.
struct StoredFrame {
  std::vector<uint8_t> bytes;
  sinks::FrameImage image;
};
Result<StoredFrame> read_frame(const std::filesystem::path& folder, uint64_t frame, const Manifest& manifest);

class FrameFolder final : public sinks::FrameSink {
 public:
  // Makes the folder. What is there of the same run is kept; the error says what else is there, or what of
  // the path is in the way.
  static Result<std::unique_ptr<FrameFolder>> open(const std::filesystem::path& folder,
                                                   const Manifest& manifest);
  ~FrameFolder() override;

  bool has(uint64_t frame) const { return kept_.contains(frame); }
  uint64_t kept() const { return kept_.size(); }
  // Of the run whose frames were kept, if there was one.
  const std::optional<Machine>& machine_before() const { return machine_before_; }
  // Now frames may come: who draws them is known.
  Result<void> begin(const Machine& machine);

  Result<void> take(sinks::FrameImage&& image) override;
  // A frame that lies in another folder, and its line there.
  Result<void> copy(uint64_t frame, const std::filesystem::path& from_folder, const std::string& line);
  // Lists the frames in order, whatever was there before.
  Result<void> finish() override;

 private:
  FrameFolder(std::filesystem::path folder, Manifest manifest)
      : folder_(std::move(folder)), manifest_(std::move(manifest)) {}
  struct Job {
    sinks::FrameImage image;
    std::string line;
    bool taken = false, written = false;
  };
  void work();
  void list_written();  // with mutex_ held
  void end_threads();
  Result<void> write_list();
  Result<void> tell_error_once();  // with mutex_ held

  Result<void> lock();

  const std::filesystem::path folder_;
  transport::UniqueFd lock_;  // two runs in one folder would write the same files
  Manifest manifest_;
  std::map<uint64_t, std::string> kept_;  // lines
  std::optional<Machine> machine_before_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::unique_ptr<Job>> jobs_;  // in order; a line is written when all before it are
  std::ofstream list_;
  std::map<uint64_t, std::string> lines_;  // of this run
  bool closing_ = false;
  std::optional<Error> error_;
  bool error_told_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace fire3dv::offline

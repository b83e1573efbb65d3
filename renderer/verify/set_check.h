// Check of a data set, or of a folder of frames, against a run that is drawn now: the files of each image,
// its line of frames.jsonl, and the files of the whole set, such as lists of labels, which are made again.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "renderer/offline/image_consumer.h"
#include "renderer/verify/image_check.h"

namespace fire3dv::verify {

class SetCheck final : public offline::ImageConsumer {
 public:
  // manifest: of the folder. sample: number of checked images; nullopt: all.
  SetCheck(std::filesystem::path folder, offline::Manifest manifest, sinks::RunProvenance provenance,
           std::optional<uint64_t> sample);
  ~SetCheck() override;

  Result<bool> begin(const offline::Manifest& manifest, const sinks::RunProvenance& provenance,
                     std::shared_ptr<offline::FrameFormat> format) override;
  bool is_wanted(uint64_t image) const override { return wanted_.contains(image); }
  Result<void> consume(sinks::FrameImage&& image) override;
  Result<void> finish() override;

  // After the run has ended.
  Outcome outcome();
  uint64_t wanted_images() const { return wanted_.size(); }
  const std::shared_ptr<const std::string>& drawn_provenance() const { return drawn_provenance_; }

 private:
  using Files = std::vector<offline::FolderFile>;
  void work();
  void end_threads();
  std::optional<std::string> check(const sinks::FrameImage& image);
  void check_run_files();
  Result<Files> make_lists() const;
  void compare(const Files& made);

  const std::filesystem::path folder_;
  const offline::Manifest manifest_;
  const sinks::RunProvenance provenance_;
  const std::optional<uint64_t> sample_;
  std::shared_ptr<offline::FrameFormat> format_;
  offline::FrameLines lines_;
  std::set<uint64_t> wanted_;
  std::shared_ptr<const std::string> drawn_provenance_;
  std::optional<std::string> unchecked_, run_difference_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<sinks::FrameImage> queue_;
  bool closing_ = false;
  uint64_t identical_ = 0;
  std::map<uint64_t, std::string> differences_;  // by image
  offline::FrameLines drawn_lines_;
  std::vector<std::string> file_differences_, notes_;
  std::vector<std::thread> workers_;
};

}  // namespace fire3dv::verify

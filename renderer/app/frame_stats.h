// Reports of a run: frame statistics.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

struct FrameCost {
  uint64_t frame_index = 0;
  double frame_ms = 0;  // since the previous image
  double cpu_ms = 0;    // recording and submission on this thread
  std::optional<double>
      pose_age_ms;  // submit time minus publish time of the newest displayed frame; same machine only
};

// Bounded history of times for the summary: a renderer may run for weeks.
class RecentTimes {
 public:
  void push_back(double ms);
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
  size_t next_ = 0;
};

// Frame statistics: cost of each image and age of its pose, as CSV rows and a summary.
class FrameStats {
 public:
  static Result<FrameStats> create(const std::filesystem::path& csv);  // empty: no file

  // Notes the time from program start to a start-up milestone, for the summary, in this order.
  void note_start(const std::string& what, double ms);
  void add(const FrameCost& cost);
  void add(const gpu::FrameTimes& times);
  // Writes the last rows; returns an error if the file could not be written.
  Result<void> finish();
  std::string summary() const;

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void write_row(const FrameCost& cost, const gpu::FrameTimes& times);

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  bool header_written_ = false;
  std::string start_;
  std::map<uint64_t, FrameCost> waiting_;  // costs without GPU times yet
  RecentTimes frame_ms_, cpu_ms_, gpu_ms_, pose_age_ms_;
  std::map<std::string, RecentTimes> pass_ms_;
  std::set<std::string> async_passes_;  // passes on the async compute queue
};

}  // namespace fire3dv::app

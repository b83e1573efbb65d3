// What each image cost and how old its pose was: a CSV row per image and a summary at the end.
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

struct FrameCost {
  uint64_t frame_index = 0;
  double frame_ms = 0;  // from the last image to this one
  double cpu_ms = 0;    // spent by this thread on recording and submitting
  std::optional<double>
      pose_age_ms;  // submit time minus publish time of the newest shown frame; same machine only
};

// The newest times, as many as a summary needs: a renderer may run for weeks.
class RecentTimes {
 public:
  void push_back(double ms);
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<double> values_;
  size_t next_ = 0;
};

class FrameStats {
 public:
  static Result<FrameStats> create(const std::filesystem::path& csv);  // empty: no file

  // How long after the program's begin something of its start was there: in the summary, in this order.
  void note_start(const std::string& what, double ms);
  void add(const FrameCost& cost);
  void add(const gpu::FrameTimes& times);
  // Writes the last rows; says when the file could not be written.
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
  std::map<uint64_t, FrameCost> waiting_;  // costs whose GPU times have not come yet
  RecentTimes frame_ms_, cpu_ms_, gpu_ms_, pose_age_ms_;
  std::map<std::string, RecentTimes> pass_ms_;
  std::set<std::string> aside_;  // those of them that ran on the side queue
};

}  // namespace fire3dv::app

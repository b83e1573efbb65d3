#include "renderer/app/frame_stats.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace fire3dv::app {

namespace {

// CSV columns: passes in frame order; 0 if a pass did not run. "tlas wait": time that the graphics queue
// waited for acceleration structures of the async compute queue.
constexpr const char* kColumns[] = {
    "pose sources",  "poses",          "transforms",    "draws",       "deform",      "deformed blas",
    "marker upload", "tlas",           "light views",   "clear",       "cull",        "raster",
    "expand",        "tiles",          "depth pyramid", "late cull",   "late raster", "late expand",
    "late tiles",    "coverage merge", "classify",      "shade",       "tlas wait",   "trace",
    "shade again",   "depth",          "forward",       "layers",      "markers",     "post",
    "fxaa",          "labels",         "outputs",       "keep poses",  "debug view",  "pick",
    "outline",       "stale overlay",  "gui",           "lens colors", "lens",        "read-back",
    "window"};

double at_fraction(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto index = static_cast<ptrdiff_t>(fraction * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<size_t>(index)];
}

std::string line(const char* what, const RecentTimes& times) {
  char text[160];
  std::snprintf(text, sizeof text, "  %-21s median %8.2f ms   p95 %8.2f ms\n", what,
                at_fraction(times.values(), 0.5), at_fraction(times.values(), 0.95));
  return text;
}

}  // namespace

void RecentTimes::push_back(double ms) {
  constexpr size_t kMaxSamples = 1 << 16;
  if (values_.size() < kMaxSamples) {
    values_.push_back(ms);
  } else {
    values_[next_] = ms;
    next_ = (next_ + 1) % kMaxSamples;
  }
}

Result<FrameStats> FrameStats::create(const std::filesystem::path& csv) {
  FrameStats stats;
  if (csv.empty()) return stats;
  stats.path_ = csv;
  stats.file_.reset(std::fopen(csv.c_str(), "w"));
  if (!stats.file_) {
    return Error{"--stats " + csv.string() + ": cannot be written: " + std::strerror(errno) +
                 "; choose another file"};
  }
  return stats;
}

void FrameStats::note_start(const std::string& what, double ms) {
  char text[160];
  std::snprintf(text, sizeof text, "%s %.0f ms", what.c_str(), ms);
  start_ += (start_.empty() ? "" : ", ") + std::string(text);
}

void FrameStats::add(const FrameCost& cost) {
  if (cost.frame_index > 0) frame_ms_.push_back(cost.frame_ms);  // the first image has no interval
  cpu_ms_.push_back(cost.cpu_ms);
  if (cost.pose_age_ms) pose_age_ms_.push_back(*cost.pose_age_ms);
  waiting_[cost.frame_index] = cost;
}

void FrameStats::add(const gpu::FrameTimes& times) {
  gpu_ms_.push_back(times.total_ms);
  for (const gpu::PassTime& pass : times.passes) {
    pass_ms_[pass.name].push_back(pass.milliseconds);
    if (pass.async_compute) async_passes_.insert(pass.name);
  }
  const auto cost = waiting_.find(times.frame_index);
  if (cost == waiting_.end()) return;
  write_row(cost->second, times);
  waiting_.erase(cost);
}

void FrameStats::write_row(const FrameCost& cost, const gpu::FrameTimes& times) {
  if (!file_) return;
  if (!header_written_) {
    std::fprintf(file_.get(), "frame,frame_ms,cpu_ms,pose_age_ms,gpu_ms");
    for (const char* column : kColumns) std::fprintf(file_.get(), ",%s_ms", column);
    std::fprintf(file_.get(), ",async_queue_ms\n");
    header_written_ = true;
  }
  std::fprintf(file_.get(), "%llu,%.4f,%.4f,", static_cast<unsigned long long>(cost.frame_index),
               cost.frame_ms, cost.cpu_ms);
  if (cost.pose_age_ms) std::fprintf(file_.get(), "%.4f", *cost.pose_age_ms);
  std::fprintf(file_.get(), ",%.4f", times.total_ms);
  for (const char* column : kColumns) {
    double sum = 0;
    for (const gpu::PassTime& pass : times.passes) {
      if (std::strcmp(pass.name, column) == 0) sum += pass.milliseconds;
    }
    std::fprintf(file_.get(), ",%.4f", sum);
  }
  double async_ms = 0;
  for (const gpu::PassTime& pass : times.passes) async_ms += pass.async_compute ? pass.milliseconds : 0;
  std::fprintf(file_.get(), ",%.4f\n", async_ms);
}

Result<void> FrameStats::finish() {
  if (!file_) return {};
  const bool good = std::fflush(file_.get()) == 0 && !std::ferror(file_.get());
  file_.reset();
  if (!good) return Error{"--stats " + path_.string() + ": the file is incomplete; is the disk full?"};
  return {};
}

std::string FrameStats::summary() const {
  std::string text = start_.empty() ? "" : "  start        " + start_ + "\n";
  text += line("image", frame_ms_) + line("CPU", cpu_ms_) + line("GPU", gpu_ms_);
  for (const char* column : kColumns) {
    const auto pass = pass_ms_.find(column);
    if (pass == pass_ms_.end()) continue;
    const char* where = async_passes_.count(column) ? ", aside" : "";
    text += line((std::string("  ") + column + where).c_str(), pass->second);
  }
  if (!pose_age_ms_.values().empty()) text += line("pose age", pose_age_ms_);
  text.pop_back();  // the caller prints the final newline
  return text;
}

}  // namespace fire3dv::app

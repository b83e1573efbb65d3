#include "tools/lab/bench/report/report.h"

#include <functional>

#include "protocol/base/file_io.h"

namespace fire3dv::bench {
namespace {

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

RunSummary summarise_run(const Condition& condition, const FrameSamples& samples) {
  const auto over_frames = [&](const std::function<double(const StageTimes&)>& value) {
    std::vector<double> values;
    for (const StageTimes& times : samples.stages) values.push_back(value(times));
    return summarise(std::move(values));
  };
  RunSummary run;
  run.condition = condition.name;
  run.shadows = condition.shadows;
  run.frame_ms = summarise(samples.frame_ms);
  run.staged_frame_ms = over_frames([](const StageTimes& times) { return times.frame_ms; });
  run.main_pass_ms = over_frames([](const StageTimes& times) { return times.main_pass_ms(); });
  run.aside_ms = over_frames([](const StageTimes& times) { return times.aside_ms; });
  run.between_ms = over_frames([](const StageTimes& times) { return times.between_ms; });
  for (size_t s = 0; s < kStages; ++s)
    run.stage_ms[s] = over_frames([s](const StageTimes& times) { return times.ms[s]; });
  run.cpu_ms = summarise(samples.cpu_ms);
  run.pose_age_ms = summarise(samples.pose_age_ms);
  run.interval_ms = summarise(samples.interval_ms);
  run.memory = samples.memory;
  return run;
}

const RunSummary* SceneReport::run(const std::string& condition) const {
  for (const RunSummary& candidate : runs) {
    if (candidate.condition == condition) return &candidate;
  }
  return nullptr;
}

Result<void> write_report(const Report& report, const std::filesystem::path& folder,
                          const std::string& name) {
  const std::pair<const char*, std::string> files[] = {
      {".md", markdown_of(report)}, {".csv", csv_of(report)}, {".svg", plot_of(report)}};
  for (const auto& [ending, text] : files) {
    if (Result<void> written = fire3dv::write_whole_file(folder / (name + ending), bytes_of(text)); !written)
      return written;
  }
  return {};
}

}  // namespace fire3dv::bench

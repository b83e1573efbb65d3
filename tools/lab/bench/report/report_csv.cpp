#include <cstdio>

#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Quotes untrusted text as one field (RFC 4180).
std::string field(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

// One row per scene, condition and quantity: easy to filter, and new quantities add no columns.
std::string csv_of(const Report& report) {
  std::string text =
      "device,commit,width,height,samples,scene,triangles,bodies,condition,quantity,unit,count,median,p95,"
      "mean,"
      "deviation,least,most\n";
  const std::string run_columns = field(report.device) + "," + field(report.commit) + "," +
                                  std::to_string(report.width) + "," + std::to_string(report.height) + "," +
                                  std::to_string(report.samples) + ",";
  for (const SceneReport& scene : report.scenes) {
    const std::string scene_columns = run_columns + scene.name + "," + std::to_string(scene.triangles) + "," +
                                      std::to_string(scene.bodies) + ",";
    const auto add = [&](const std::string& condition, const std::string& quantity, const char* unit,
                         const Summary& s) {
      text += scene_columns + field(condition) + "," + quantity + "," + unit + "," + std::to_string(s.count) +
              "," + number(s.median) + "," + number(s.p95) + "," + number(s.mean) + "," +
              number(s.deviation) + "," + number(s.least) + "," + number(s.most) + "\n";
    };
    add("", "made in", "s", summarise({scene.make_s}));
    add("", "loaded in", "s", summarise({scene.load_s}));
    for (const RunSummary& run : scene.runs) {
      add(run.condition, "whole frame", "ms", run.frame_ms);
      add(run.condition, "frame by stages", "ms", run.staged_frame_ms);
      if (!run.shadows) add(run.condition, "main pass", "ms", run.main_pass_ms);
      for (size_t s = 0; s < kStages; ++s)
        add(run.condition, stage_name(static_cast<Stage>(s)), "ms", run.stage_ms[s]);
      add(run.condition, "side queue", "ms", run.aside_ms);
      add(run.condition, "between", "ms", run.between_ms);
      add(run.condition, "CPU", "ms", run.cpu_ms);
      add(run.condition, "pose age", "ms", run.pose_age_ms);
      add(run.condition, "frame to frame", "ms", run.interval_ms);
      const auto add_bytes = [&](const char* quantity, std::optional<uint64_t> bytes) {
        if (bytes) add(run.condition, quantity, "byte", summarise({static_cast<double>(*bytes)}));
      };
      add_bytes("GPU memory", run.memory.gpu_allocated_bytes);
      add_bytes("GPU memory by the driver", run.memory.gpu_used_bytes);
      add_bytes("process memory", run.memory.resident_bytes);
      add_bytes("process memory at most", run.memory.most_resident_bytes);
    }
  }
  return text;
}

}  // namespace fire3dv::bench

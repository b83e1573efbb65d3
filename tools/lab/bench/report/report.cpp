#include "tools/lab/bench/report/report.h"

#include <cstdarg>
#include <cstdio>
#include <functional>

#include "base/files.h"

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
  const std::pair<const char*, std::string> files[] = {{".md", markdown_of(report)},
                                                       {".csv", csv_of(report)}};
  for (const auto& [ending, text] : files) {
    if (Result<void> written = fire3dv::write_whole_file(folder / (name + ending), bytes_of(text)); !written)
      return written;
  }
  return {};
}

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
      add_bytes("process memory at most", run.memory.peak_resident_bytes);
    }
  }
  return text;
}

namespace {

std::string text_of(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string text_of(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

// Prints three decimals of short times and none of long ones, where they would be noise.
std::string ms_text(double ms) {
  return text_of(ms >= 100 ? "%.0f" : ms >= 10 ? "%.1f" : "%.3f", ms);
}

std::string mebibytes(std::optional<uint64_t> bytes) {
  return bytes ? text_of("%.0f", static_cast<double>(*bytes) / (1 << 20)) : "-";
}

std::string head(const std::vector<std::string>& columns) {
  std::string first = "|", second = "|";
  for (const std::string& column : columns) {
    first += " " + column + " |";
    second += "---|";
  }
  return first + "\n" + second + "\n";
}

std::string row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

std::string whole_frames(const Report& report) {
  std::string text = head({"scene", "triangles", "bodies", "whole frame ms", "p95", "main pass ms", "p95",
                           "CPU ms", "p95", "pose age ms", "p95", "frame to frame ms", "GPU memory MiB",
                           "driver says MiB", "process MiB", "made in s", "loaded in s"});
  for (const SceneReport& scene : report.scenes) {
    const RunSummary* run = scene.run(kProduct);
    const RunSummary* main_pass = scene.run(kProductMain);
    if (!run || !main_pass) continue;
    text += row({scene.name, std::to_string(scene.triangles), std::to_string(scene.bodies),
                 ms_text(run->frame_ms.median), ms_text(run->frame_ms.p95),
                 ms_text(main_pass->main_pass_ms.median), ms_text(main_pass->main_pass_ms.p95),
                 ms_text(run->cpu_ms.median), ms_text(run->cpu_ms.p95), ms_text(run->pose_age_ms.median),
                 ms_text(run->pose_age_ms.p95), ms_text(run->interval_ms.median),
                 mebibytes(run->memory.gpu_allocated_bytes), mebibytes(run->memory.gpu_used_bytes),
                 mebibytes(run->memory.resident_bytes), text_of("%.1f", scene.make_s),
                 text_of("%.1f", scene.load_s)});
  }
  return text;
}

enum class Statistic { median, mean };

std::string stages(const Report& report, const char* condition, Statistic statistic) {
  std::vector<std::string> columns{"scene"};
  for (size_t s = 0; s < kStages; ++s) {
    if (static_cast<Stage>(s) != Stage::readback) columns.emplace_back(stage_name(static_cast<Stage>(s)));
  }
  columns.insert(columns.end(), {"beside", "between", "sum", "whole frame", "main pass"});
  const auto cell = [statistic](const Summary& summary) {
    if (summary.most <= 0) return std::string("-");  // the pass did not run
    if (statistic == Statistic::median) return ms_text(summary.median);
    return ms_text(summary.mean) + " ± " + ms_text(summary.deviation);
  };
  std::string text = head(columns);
  for (const SceneReport& scene : report.scenes) {
    const RunSummary* run = scene.run(condition);
    if (!run) continue;
    std::vector<std::string> cells{scene.name};
    for (size_t s = 0; s < kStages; ++s) {
      if (static_cast<Stage>(s) != Stage::readback) cells.push_back(cell(run->stage_ms[s]));
    }
    cells.push_back(cell(run->aside_ms));
    cells.push_back(cell(run->between_ms));
    cells.push_back(cell(run->staged_frame_ms));
    cells.push_back(cell(run->frame_ms));
    // With shadows on, cull and raster include the shadow maps.
    cells.push_back(run->shadows ? "" : cell(run->main_pass_ms));
    text += row(cells);
  }
  return text;
}

std::string about(const Report& report) {
  std::string unique = "- Triangles in memory, without those of shared meshes:";
  for (const SceneReport& scene : report.scenes)
    unique +=
        text_of(" %s %llu,", scene.name.c_str(), static_cast<unsigned long long>(scene.unique_triangles));
  unique.back() = '.';
  return "- Command: `" + report.command + "`\n- Commit: " + report.commit + "; date: " + report.date +
         "\n- Device: " + report.device + "; driver: " + report.driver + "\n- " +
         text_of(
             "%ux%u, %u samples per pixel, %u lights with shadows, textures of %u pixels a side, FXAA %s\n",
             report.width, report.height, report.samples, report.lights, report.texture_side,
             report.fxaa ? "on" : "off") +
         "- Drawn " + report.raster + "; shadows: " + report.shadows + "\n" +
         text_of(
             "- Each row: %u frames after at least %u for warm-up, and between them as many that are timed "
             "stage by "
             "stage\n",
             report.frames, report.warm_up) +
         unique + "\n";
}

}  // namespace

std::string markdown_of(const Report& report) {
  std::string text = "# Frame times on " + report.device + "\n\n" + about(report);
  if (report.scenes.empty()) return text;
  const auto ran = [&](const char* condition) { return report.scenes.front().run(condition) != nullptr; };
  if (ran(kProduct)) {
    text +=
        "\n## As the product draws\n\nMedians; the main pass is cull, raster and shading of a run without "
        "shadows.\n\n" +
        whole_frames(report) + "\n## Its stages, median ms\n\n" +
        stages(report, kProduct, Statistic::median) + "\n## Its stages without shadows, median ms\n\n" +
        stages(report, kProductMain, Statistic::median);
  }
  for (const char* condition : kRayConditions) {
    if (ran(condition))
      text += "\n## Stages with ray effects: " + std::string(condition) + ", median ms\n\n" +
              stages(report, condition, Statistic::median);
  }
  if (ran(kPaper)) {
    text += "\n## The paper's conditions (no culling), mean ± standard deviation, ms\n\n" +
            stages(report, kPaper, Statistic::mean) +
            "\n## The same without shadows, mean ± standard deviation, ms\n\n" +
            stages(report, kPaperMain, Statistic::mean);
  }
  return text;
}

}  // namespace fire3dv::bench

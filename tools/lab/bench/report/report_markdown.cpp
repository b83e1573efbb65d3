#include <cstdarg>
#include <cstdio>

#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {
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

enum class ViewerDocument { median, mean };

std::string stages(const Report& report, const char* condition, ViewerDocument show) {
  std::vector<std::string> columns{"scene"};
  for (size_t s = 0; s < kStages; ++s) {
    if (static_cast<Stage>(s) != Stage::readback) columns.emplace_back(stage_name(static_cast<Stage>(s)));
  }
  columns.insert(columns.end(), {"beside", "between", "sum", "whole frame", "main pass"});
  const auto cell = [show](const Summary& summary) {
    if (summary.most <= 0) return std::string("-");  // the pass did not run
    if (show == ViewerDocument::median) return ms_text(summary.median);
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
         text_of("%ux%u, %u samples a pixel, %u lights with shadows, textures of %u pixels a side, FXAA %s\n",
                 report.width, report.height, report.samples, report.lights, report.texture_side,
                 report.fxaa ? "on" : "off") +
         "- Drawn " + report.raster + "; shadows by " + report.shadows + "\n" +
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
        stages(report, kProduct, ViewerDocument::median) + "\n## Its stages without shadows, median ms\n\n" +
        stages(report, kProductMain, ViewerDocument::median);
  }
  if (ran(kPaper)) {
    text += "\n## The paper's conditions (no culling), mean ± standard deviation, ms\n\n" +
            stages(report, kPaper, ViewerDocument::mean) +
            "\n## The same without shadows, mean ± standard deviation, ms\n\n" +
            stages(report, kPaperMain, ViewerDocument::mean);
  }
  return text;
}

}  // namespace fire3dv::bench

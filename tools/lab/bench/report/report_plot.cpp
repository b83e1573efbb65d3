#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {

namespace {

std::string coordinate_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string attribute(const char* name, double value) {
  return std::string(" ") + name + "=\"" + coordinate_text(value) + "\"";
}

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : words) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '>':
        text += "&gt;";
        break;
      default:
        text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return text;
}

}  // namespace

Svg::Svg(double width, double height)
    : body_("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + coordinate_text(width) + " " +
            coordinate_text(height) + "\"" + attribute("width", width) + attribute("height", height) +
            " font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n") {}

void Svg::line(Point from, Point to, const std::string& colour, double width) {
  body_ += "<line" + attribute("x1", from.x) + attribute("y1", from.y) + attribute("x2", to.x) +
           attribute("y2", to.y) + " stroke=\"" + colour + "\"" + attribute("stroke-width", width) + "/>\n";
}

void Svg::polyline(const std::vector<Point>& points, const std::string& colour, bool dashed) {
  body_ += "<polyline points=\"";
  for (const Point& point : points) body_ += coordinate_text(point.x) + "," + coordinate_text(point.y) + " ";
  body_ += "\" fill=\"none\" stroke-width=\"2\" stroke=\"" + colour + "\"" +
           (dashed ? " stroke-dasharray=\"6 4\"" : "") + "/>\n";
}

void Svg::circle(Point center, double radius, const std::string& colour) {
  body_ += "<circle" + attribute("cx", center.x) + attribute("cy", center.y) + attribute("r", radius) +
           " fill=\"" + colour + "\"/>\n";
}

void Svg::text(Point at, const std::string& words, Anchor anchor, double size) {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  body_ += "<text" + attribute("x", at.x) + attribute("y", at.y) + attribute("font-size", size) +
           " text-anchor=\"" + kAnchors[static_cast<int>(anchor)] + "\">" + escaped(words) + "</text>\n";
}

namespace {

constexpr double kWidth = 920, kHeight = 520;
constexpr double kLeft = 70, kRight = 640, kTop = 60, kBottom = 460;

struct Series {
  const char* condition;
  bool main_pass;
  const char* label;
  const char* colour;
  bool dashed;
};
constexpr Series kSeries[] = {
    {kProduct, false, "whole frame", "#c0392b", false},
    {kPaper, false, "whole frame, no culling", "#c0392b", true},
    {kProductMain, true, "main pass", "#2471a3", false},
    {kPaperMain, true, "main pass, no culling", "#2471a3", true},
};

// Results of the AMBF paper on its own scenes and device, for comparison.
struct Mark {
  double triangles, ms;
};
struct MarkSeries {
  const char* label;
  const char* colour;
  std::vector<Mark> marks;
};
std::vector<MarkSeries> marks_of(const Report& report) {
  if (report.on_cpu) return {};  // times of a CPU device would not share the scale
  return {{"paper: frame, RTX 4090", "#e59866", {{7e6, 2.0}}},
          {"paper: main pass, RTX 4090", "#7fb3d5", {{223e3, 0.55}, {550e3, 0.55}}},
          {"AMBF: main pass, by the paper", "#999999", {{223e3, 3.3}, {550e3, 4.7}}}};
}

const Summary& summary_of(const RunSummary& run, const Series& series) {
  return series.main_pass ? run.main_pass_ms : run.frame_ms;
}

std::string tick_text(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", ms);
  return text;
}

// Logarithmic axes: scene sizes double, and devices differ by orders of magnitude.
struct Axes {
  double least_triangles, max_triangles, least_ms, max_ms;

  Point at(double triangles, double ms) const {
    const double x = std::log(triangles / least_triangles) / std::log(max_triangles / least_triangles);
    const double y = std::log(ms / least_ms) / std::log(max_ms / least_ms);
    return {std::lerp(kLeft, kRight, x), std::lerp(kBottom, kTop, y)};
  }
};

// Rounds to 1, 2 or 5 times a power of ten.
double round_tick(double value, bool up) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  double best = up ? 10 * power : power;
  for (const double step : {1.0, 2.0, 5.0}) {
    if (up && step * power >= value) return step * power;
    if (!up && step * power <= value) best = step * power;
  }
  return best;
}

Axes axes_of(const Report& report) {
  Axes axes{1e18, 1, 1e18, 0};
  for (const SceneReport& scene : report.scenes) {
    const auto triangles = static_cast<double>(scene.triangles);
    axes.least_triangles = std::min(axes.least_triangles, triangles / 1.3);
    axes.max_triangles = std::max(axes.max_triangles, triangles * 1.3);
    for (const Series& series : kSeries) {
      const RunSummary* run = scene.run(series.condition);
      if (!run) continue;
      axes.least_ms = std::min(axes.least_ms, summary_of(*run, series).median);
      axes.max_ms = std::max(axes.max_ms, summary_of(*run, series).p95);
    }
  }
  for (const MarkSeries& series : marks_of(report)) {
    for (const Mark& mark : series.marks) {
      axes.least_triangles = std::min(axes.least_triangles, mark.triangles / 1.3);
      axes.max_triangles = std::max(axes.max_triangles, mark.triangles * 1.3);
      axes.least_ms = std::min(axes.least_ms, mark.ms);
      axes.max_ms = std::max(axes.max_ms, mark.ms);
    }
  }
  axes.least_ms = round_tick(std::clamp(axes.least_ms, 1e-4, 1e6), false);
  axes.max_ms = round_tick(std::max(axes.max_ms, axes.least_ms * 1.5), true);
  return axes;
}

void draw_axes(Svg& svg, const Axes& axes, const Report& report) {
  constexpr const char* kGrid = "#dddddd";
  for (double tick = axes.least_ms; tick <= axes.max_ms * 1.001; tick = round_tick(tick * 1.01, true)) {
    const double y = axes.at(axes.least_triangles, tick).y;
    svg.line({kLeft, y}, {kRight, y}, kGrid);
    svg.text({kLeft - 8, y + 4}, tick_text(tick), Svg::Anchor::end);
  }
  for (const SceneReport& scene : report.scenes) {
    const double x = axes.at(static_cast<double>(scene.triangles), axes.least_ms).x;
    svg.line({x, kTop}, {x, kBottom}, kGrid);
    svg.text({x, kBottom + 20}, scene.name, Svg::Anchor::middle);
  }
  svg.text({(kLeft + kRight) / 2, kBottom + 42}, "triangles", Svg::Anchor::middle);
  svg.text({kLeft - 50, kTop - 12}, "ms of GPU time");
  char about[160];
  std::snprintf(about, sizeof about, "%ux%u, %u samples, %u lights with shadows; medians, bars up to p95",
                report.width, report.height, report.samples, report.lights);
  svg.text({kLeft - 50, 24}, report.device, Svg::Anchor::start, 16);
  svg.text({kRight, kTop - 12}, about, Svg::Anchor::end, 11);
}

}  // namespace

std::string plot_of(const Report& report) {
  Svg svg(kWidth, kHeight);
  if (report.scenes.empty()) return svg.finish();
  const Axes axes = axes_of(report);
  draw_axes(svg, axes, report);
  double legend_y = kTop + 10;
  for (const Series& series : kSeries) {
    std::vector<Point> points;
    for (const SceneReport& scene : report.scenes) {
      const RunSummary* run = scene.run(series.condition);
      if (!run) continue;
      const Summary& summary = summary_of(*run, series);
      const auto triangles = static_cast<double>(scene.triangles);
      points.push_back(axes.at(triangles, std::max(summary.median, axes.least_ms)));
      svg.line(points.back(), axes.at(triangles, std::max(summary.p95, axes.least_ms)), series.colour);
      svg.circle(points.back(), 3.5, series.colour);
    }
    if (points.empty()) continue;
    svg.polyline(points, series.colour, series.dashed);
    svg.polyline({{kRight + 20, legend_y}, {kRight + 50, legend_y}}, series.colour, series.dashed);
    svg.text({kRight + 58, legend_y + 4}, series.label, Svg::Anchor::start, 12);
    legend_y += 24;
  }
  for (const MarkSeries& series : marks_of(report)) {
    for (const Mark& mark : series.marks) svg.circle(axes.at(mark.triangles, mark.ms), 6, series.colour);
    svg.circle({kRight + 35, legend_y}, 6, series.colour);
    svg.text({kRight + 58, legend_y + 4}, series.label, Svg::Anchor::start, 12);
    legend_y += 24;
  }
  return svg.finish();
}

}  // namespace fire3dv::bench

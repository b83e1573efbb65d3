#include "renderer/dataset/pages/page.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "base/image/jpeg_encoder.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::json;

constexpr size_t kMaxSheetImages = 24;
constexpr uint32_t kThumbnailWidth = 320;
constexpr uint32_t kJpegQuality = 85;
constexpr size_t kMaxRows = 500;    // of a table
constexpr size_t kMaxCharts = 200;  // of drawn parameters

constexpr const char* kStyle = R"(
body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;max-width:86rem;padding:0 1rem;color:#1c2733;background:#fff}
h1{font-size:1.5rem;margin:0 0 .3rem}h2{font-size:1.1rem;margin:2rem 0 .6rem}
p{margin:.3rem 0}code{background:#eef2f5;padding:.1rem .3rem;border-radius:3px;overflow-wrap:anywhere}
.warn{background:#fff4dc;border-left:4px solid #d78a00;padding:.4rem .8rem;margin:.3rem 0}
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(19rem,1fr));gap:1rem}
figure{margin:0}figure svg{width:100%;height:auto;display:block;background:#222;border-radius:4px}
figcaption{font-size:.8rem;color:#56636f;padding-top:.2rem}
table{border-collapse:collapse;font-size:.88rem}td,th{padding:.2rem .7rem;border-bottom:1px solid #dde3e8;text-align:left}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(24rem,1fr));gap:1.5rem}
.charts svg{width:100%;height:auto}.charts h3{font-size:.95rem;margin:0 0 .3rem}
@media (prefers-color-scheme:dark){body{background:#14191e;color:#dbe3ea}code{background:#232c34}
.warn{background:#3a2f14}td,th{border-color:#2d3841}figcaption{color:#93a1ad}svg text.axis{fill:#93a1ad}}
)";

std::string base64(std::span<const uint8_t> bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const uint32_t three = uint32_t{bytes[i]} << 16 |
                           (i + 1 < bytes.size() ? uint32_t{bytes[i + 1]} << 8 : 0u) |
                           (i + 2 < bytes.size() ? uint32_t{bytes[i + 2]} : 0u);
    for (int digit = 0; digit < 4; ++digit)
      text += i + static_cast<size_t>(digit) > bytes.size() ? '=' : kDigits[three >> (18 - 6 * digit) & 63];
  }
  return text;
}

// Well separated colours for neighbouring numbers.
struct Color {
  uint8_t red, green, blue;
};
Color color_of(uint32_t number) {
  constexpr Color kColors[] = {{230, 75, 53},  {77, 187, 213}, {0, 160, 135},  {244, 180, 60},
                               {137, 90, 200}, {220, 0, 120},  {120, 200, 70}, {0, 115, 255},
                               {255, 127, 80}, {0, 200, 200},  {170, 140, 90}, {255, 105, 180}};
  return kColors[number % std::size(kColors)];
}
std::string css(const Color& color) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", color.red, color.green, color.blue);
  return text;
}

// Tints the visible pixels of each instance, then reduces the image by averages of squares of pixels.
std::vector<uint8_t> make_thumbnail(sinks::FrameImage& image, const json& instances, uint32_t factor) {
  const uint64_t pixels = uint64_t{image.width} * image.height;
  for (const json& instance : instances) {
    const Color color = color_of(instance.value("instance", 0u));
    for (const auto& [first, end] : decode_counts(instance.value("counts", ""), pixels)) {
      for (uint32_t i = first; i < end; ++i) {
        uint8_t* const pixel =
            image.rgba8.data() + 4 * (size_t{i % image.height} * image.width + i / image.height);
        constexpr int kTint = 35, kWhole = 100;  // percent
        const uint8_t tint[3] = {color.red, color.green, color.blue};
        for (int c = 0; c < 3; ++c)
          pixel[c] = static_cast<uint8_t>((pixel[c] * (kWhole - kTint) + tint[c] * kTint) / kWhole);
      }
    }
  }
  const uint32_t width = image.width / factor, height = image.height / factor;
  std::vector<uint8_t> small(size_t{4} * width * height, 255);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      for (uint32_t c = 0; c < 3; ++c) {
        uint32_t sum = 0;
        for (uint32_t dy = 0; dy < factor; ++dy) {
          for (uint32_t dx = 0; dx < factor; ++dx)
            sum += image.rgba8[4 * (size_t{y * factor + dy} * image.width + x * factor + dx) + c];
        }
        small[4 * (size_t{y} * width + x) + c] = static_cast<uint8_t>(sum / (factor * factor));
      }
    }
  }
  return small;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

// Boxes around visible parts, names and keypoints, in pixels of the image.
std::string overlay(const Description& description, const json& line, double unit) {
  std::string svg;
  // An SVG of this size has its origin at the outer corner of the first pixel.
  for (const json& instance : line.value("instances", json::array())) {
    const auto number_of = instance.value("instance", 0u);
    const std::string color = css(color_of(number_of));
    if (instance.value("px_count_visib", uint64_t{0}) == 0) continue;
    const json& box = instance.at("bbox_visib");
    const double left = box.at(0), top = box.at(1), width = box.at(2), height = box.at(3);
    svg += "<rect x=\"" + number(left) + "\" y=\"" + number(top) + "\" width=\"" + number(width) +
           "\" height=\"" + number(height) + "\" fill=\"none\" stroke=\"" + color + "\" stroke-width=\"" +
           number(1.5 * unit) + "\"/>";
    const Instance* const known = description.find_instance(number_of);
    if (width * height < 400 * unit * unit || !known) continue;  // no room for a name
    const std::string name = known->name.empty() ? std::to_string(number_of) : known->name;
    svg += "<text x=\"" + number(left + 2 * unit) + "\" y=\"" + number(top + 11 * unit) + "\" font-size=\"" +
           number(11 * unit) + "\" font-family=\"sans-serif\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"" +
           number(2.5 * unit) + "\" paint-order=\"stroke\">" + html_text(name.substr(0, 40)) + "</text>";
  }
  for (const json& point : line.value("keypoints", json::array())) {
    const std::string state = point.value("state", "");
    if (state == "outside") continue;
    svg += "<circle cx=\"" + number(point.at("pixel").at(0).get<double>() + 0.5) + "\" cy=\"" +
           number(point.at("pixel").at(1).get<double>() + 0.5) + "\" r=\"" + number(3.5 * unit) +
           "\" fill=\"" + (state == "visible" ? "#ff0" : "none") + "\" stroke=\"#000\" stroke-width=\"" +
           number(unit) + "\"><title>" + html_text(point.value("name", "")) + ", " + state +
           "</title></circle>";
  }
  return svg;
}

Result<std::string> make_figure(const std::filesystem::path& folder, const Description& description,
                                const Layout& layout, uint64_t image, const std::string& text) {
  const json line = json::parse(text);
  const std::string name = layout.color_name(description, image);
  auto pixels = layout.read_color(folder, description, image);
  if (!pixels) return pixels.error();
  sinks::FrameImage colors;
  colors.width = description.width;
  colors.height = description.height;
  colors.rgba8 = std::move(*pixels);
  const uint32_t factor =
      std::max(1u, std::min({colors.width / kThumbnailWidth, colors.width, colors.height}));
  const std::vector<uint8_t> small = make_thumbnail(colors, line.value("instances", json::array()), factor);
  JpegEncoder encoder;
  const uint32_t width = colors.width / factor;
  const auto jpeg =
      encoder.encode(small.data(), width, colors.height / factor, size_t{4} * width, kJpegQuality);
  if (!jpeg) return jpeg.error();
  const std::string size = std::to_string(colors.width) + " " + std::to_string(colors.height);
  const double unit = static_cast<double>(colors.width) / kThumbnailWidth;
  std::string figure =
      "<figure><svg viewBox=\"0 0 " + size + "\"><image width=\"" + std::to_string(width * factor) +
      "\" height=\"" + std::to_string(colors.height / factor * factor) + "\" href=\"data:image/jpeg;base64," +
      base64(*jpeg) + "\"/>" + overlay(description, line, unit) + "</svg><figcaption>" + html_text(name) +
      ", " + html_text(description.cameras[description.index_of_camera(image)]) + ": " +
      counted(line.at("instances").size(), "instance") + "</figcaption></figure>\n";
  return figure;
}

// The title is HTML.
std::string make_chart(const Histogram& histogram) {
  constexpr int kRow = 18, kBar = 230, kLeft = 110, kRight = 60;
  const auto rows = static_cast<int>(histogram.counts.size());
  const uint64_t most =
      std::max<uint64_t>(1, *std::max_element(histogram.counts.begin(), histogram.counts.end()));
  std::string svg = "<div><h3>" + histogram.title + (histogram.unit.empty() ? "" : ", " + histogram.unit) +
                    "</h3><svg viewBox=\"0 0 " + std::to_string(kLeft + kBar + kRight) + " " +
                    std::to_string(kRow * rows) + "\" font-size=\"11\" font-family=\"sans-serif\">";
  for (int row = 0; row < rows; ++row) {
    const uint64_t count = histogram.counts[static_cast<size_t>(row)];
    const double length = kBar * static_cast<double>(count) / static_cast<double>(most);
    const std::string y = std::to_string(kRow * row + 13);
    svg += "<text class=\"axis\" x=\"" + std::to_string(kLeft - 6) + "\" y=\"" + y +
           "\" text-anchor=\"end\">" + html_text(histogram.ranges[static_cast<size_t>(row)]) +
           "</text><rect x=\"" + std::to_string(kLeft) + "\" y=\"" + std::to_string(kRow * row + 3) +
           "\" width=\"" + number(length) + "\" height=\"" + std::to_string(kRow - 5) +
           "\" fill=\"#3b82b8\"/><text class=\"axis\" x=\"" + number(kLeft + length + 5) + "\" y=\"" + y +
           "\">" + std::to_string(count) + "</text>";
  }
  return svg + "</svg></div>\n";
}

std::string make_object_table(const Description& description, const Statistics& statistics) {
  std::string html =
      "<table><tr><th class=n>obj_id</th><th>name</th><th class=n>diameter, mm</th><th class=n>labels</th>"
      "<th class=n>images</th><th class=n>truncated</th><th class=n>distance, m</th></tr>\n";
  for (size_t i = 0; i < std::min(description.objects.size(), kMaxRows); ++i) {
    const Object& object = description.objects[i];
    const auto found = statistics.objects.find(object.id);
    const ObjectCounts counts = found == statistics.objects.end() ? ObjectCounts() : found->second;
    char range[64];
    std::snprintf(range, sizeof range, "%.3f - %.3f", counts.least_m, counts.most_m);
    html += "<tr><td class=n>" + std::to_string(object.id) + "</td><td>" + html_text(object.name) +
            "</td><td class=n>" + number(object.diameter_mm) + "</td><td class=n>" +
            std::to_string(counts.labels) + "</td><td class=n>" + std::to_string(counts.images) +
            "</td><td class=n>" + (statistics.has_silhouettes ? std::to_string(counts.truncated) : "-") +
            "</td><td class=n>" + (counts.labels ? range : "-") + "</td></tr>\n";
  }
  html += "</table>\n";
  if (description.objects.size() > kMaxRows)
    html += "<p>" + std::to_string(description.objects.size() - kMaxRows) + " more: dataset.json</p>\n";
  return html;
}

std::string make_keypoint_table(const Statistics& statistics) {
  if (statistics.keypoints.empty()) return {};
  std::string html =
      "<h2>Keypoints</h2><table><tr><th>name</th><th class=n>visible</th><th class=n>hidden</th>"
      "<th class=n>outside</th></tr>\n";
  for (const auto& [name, counts] : statistics.keypoints) {
    html += "<tr><td>" + html_text(name) + "</td>";
    for (const uint64_t each : counts) html += "<td class=n>" + std::to_string(each) + "</td>";
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : printable_text(text, text.size())) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

Result<std::string> make_page(const std::filesystem::path& folder, const Description& description,
                              const Layout& layout, const Statistics& statistics,
                              const offline::FrameLines& lines) {
  std::string html =
      "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport "
      "content=\"width=device-width\"><title>Data set</title><style>";
  html += kStyle;
  html +=
      "</style>\n<h1>Data set, format " + html_text(description.format) + "</h1>\n<p>" +
      counted(statistics.images, "image") + " of " + std::to_string(description.width) + "x" +
      std::to_string(description.height) + ", " + counted(description.cameras.size(), "camera") + ", " +
      counted(description.objects.size(), "object") + ", " +
      counted(description.instances.size(), "instance") + ", " + counted(statistics.labels, "label") +
      "</p>\n<p>Licence: " + (description.license.empty() ? "not stated" : html_text(description.license)) +
      "</p>\n<p><code>" + html_text(description.command) + "</code></p>\n";
  if (!statistics.warnings.empty()) html += "<h2>Warnings</h2>\n";
  for (const std::string& warning : statistics.warnings)
    html += "<div class=warn>" + html_text(warning) + "</div>\n";
  html += "<h2>Images with their labels</h2>\n<div class=sheet>\n";
  const size_t shown = std::min(lines.size(), kMaxSheetImages);
  for (size_t i = 0; i < shown; ++i) {
    const auto at = lines.find(lines.size() * i / shown);
    if (at == lines.end()) continue;
    auto figure = make_figure(folder, description, layout, at->first, at->second);
    if (!figure) return figure.error();
    html += *figure;
  }
  html += "</div>\n<h2>Objects</h2>\n" + make_object_table(description, statistics);
  html += make_keypoint_table(statistics);
  html += "<h2>Distributions</h2>\n<div class=charts>\n";
  for (const Histogram& histogram : statistics.histograms) html += make_chart(histogram);
  html += "</div>\n";
  if (!statistics.drawn.empty()) {
    html +=
        "<h2>Drawn parameters</h2>\n<p>Images by the value of each parameter of the randomisation, seed " +
        std::to_string(description.seed) + "</p>\n<div class=charts>\n";
    const size_t charts = std::min(statistics.drawn.size(), kMaxCharts);
    for (size_t i = 0; i < charts; ++i) {
      Histogram histogram = statistics.drawn[i];
      histogram.title = html_text(histogram.title);  // has names of the scene
      html += make_chart(histogram);
    }
    html += "</div>\n";
    if (statistics.drawn.size() > charts)
      html += "<p>" + std::to_string(statistics.drawn.size() - charts) + " more: frames.jsonl</p>\n";
  }
  return html + "</html>\n";
}

}  // namespace fire3dv::dataset

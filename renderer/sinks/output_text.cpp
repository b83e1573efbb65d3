#include "renderer/sinks/output_text.h"

#include <cmath>
#include <cstdint>
#include <cstdio>

#include "base/text.h"
#include "renderer/sinks/png.h"

namespace fire3dv::sinks {

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : printable_text(text, text.size())) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string safe_file_name(std::string_view text) {
  constexpr size_t kMaxBytes = 100;
  std::string out;
  for (const char c : text.substr(0, kMaxBytes)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || c == '.';
    out += plain ? c : '_';
  }
  if (out.empty() || out[0] == '.') out.insert(out.begin(), '_');
  return out;
}

namespace {

template <typename Values, typename Write>
std::string list(const Values& values, Write&& write) {
  std::string text = "[";
  for (const auto& value : values) text += (text.size() > 1 ? "," : "") + write(value);
  return text + "]";
}

std::string number(float value) {
  if (!std::isfinite(value)) return "null";  // JSON has no literal for it
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(value));
  return text;
}

std::string stream_entry(const state::FrameTag& tag) {
  return "{\"stream\":" + json_string(tag.stream) + ",\"epoch\":\"" + hex64(tag.epoch) +
         "\",\"sequence\":" + std::to_string(tag.sequence) +
         ",\"sim_time_ns\":" + std::to_string(tag.sim_time_ns) +
         ",\"publish_time_ns\":" + std::to_string(tag.publish_time_ns) + ",\"state\":\"" +
         state::condition_name(tag.condition) + "\"}";
}

std::string labels(uint32_t instance, uint32_t semantic) {
  return "{\"instance\":" + std::to_string(instance) + ",\"semantic\":" + std::to_string(semantic);
}

std::string box_entry(const wire::BoxRecord2d& box) {
  return labels(box.instance, box.semantic) + ",\"box\":[" + std::to_string(box.min_x) + "," +
         std::to_string(box.min_y) + "," + std::to_string(box.max_x) + "," + std::to_string(box.max_y) +
         "],\"pixels\":" + std::to_string(box.pixels) + "}";
}

std::string box_entry(const wire::BoxRecord3d& box) {
  return labels(box.instance, box.semantic) + ",\"world_from_box\":" + list(box.world_from_box, number) + "}";
}

std::string amodal_entry(const wire::AmodalRecord& record) {
  const float share = static_cast<float>(record.visible_pixels) / static_cast<float>(record.pixels);
  return labels(record.instance, record.semantic) + ",\"px_all\":" + std::to_string(record.pixels) +
         ",\"px_visible\":" + std::to_string(record.visible_pixels) + ",\"visibility\":" + number(share) +
         ",\"box_full\":[" + std::to_string(record.min_x) + "," + std::to_string(record.min_y) + "," +
         std::to_string(record.max_x) + "," + std::to_string(record.max_y) +
         "],\"truncated\":" + (record.is_truncated != 0 ? "true" : "false") + "}";
}

std::string plane_entries(const FrameFiles& files, const FrameImage& image) {
  std::string text;
  for (size_t i = 0; i < image.planes.size(); ++i) {
    text += (i ? "," : "") + json_string(wire::info_of(image.planes[i].output).cli_name) + ":" +
            json_string(files.planes[i].string());
  }
  if (!files.amodal.empty())
    text += (text.empty() ? "" : ",") + std::string("\"amodal\":") + json_string(files.amodal.string());
  return "{" + text + "}";
}

}  // namespace

std::string frame_line(const FrameFiles& files, const FrameImage& image) {
  std::string line = "{";
  if (!files.color.empty()) line += "\"file\":" + json_string(files.color.string()) + ",";
  line += "\"frame\":" + std::to_string(image.frame_index) + ",\"camera\":" + json_string(image.camera) +
          ",\"width\":" + std::to_string(image.width) + ",\"height\":" + std::to_string(image.height);
  if (!image.planes.empty() || !files.amodal.empty()) line += ",\"planes\":" + plane_entries(files, image);
  if (image.boxes2d)
    line +=
        ",\"boxes2d\":" + list(*image.boxes2d, [](const wire::BoxRecord2d& box) { return box_entry(box); });
  if (image.boxes3d)
    line +=
        ",\"boxes3d\":" + list(*image.boxes3d, [](const wire::BoxRecord3d& box) { return box_entry(box); });
  if (image.amodal) line += ",\"amodal\":" + list(image.amodal->records, amodal_entry);
  if (image.path_traced)
    line += ",\"renderer\":\"path\",\"samples_per_pixel\":" +
            std::to_string(image.path_traced->samples_per_pixel) +
            ",\"bounces\":" + std::to_string(image.path_traced->bounces) +
            ",\"seed\":" + std::to_string(image.path_traced->seed);
  if (!image.hidden_streams.empty()) line += ",\"hidden_streams\":" + list(image.hidden_streams, json_string);
  return line + ",\"streams\":" + list(image.shown, stream_entry) + "}\n";
}

}  // namespace fire3dv::sinks

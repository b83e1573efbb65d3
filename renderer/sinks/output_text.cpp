#include "renderer/sinks/output_text.h"

#include <cmath>
#include <cstdint>
#include <cstdio>

#include "renderer/sinks/png.h"

namespace fire3dv::sinks {

namespace {

// Byte length of the valid UTF-8 character at the start, or 0. Overlong forms, surrogates and values above
// U+10FFFF are invalid.
size_t character_length(std::string_view text) {
  const auto at = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const auto follows = [&](size_t i, uint8_t low = 0x80, uint8_t high = 0xbf) {
    return i < text.size() && at(i) >= low && at(i) <= high;
  };
  const uint8_t lead = at(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xc2 && lead <= 0xdf) return follows(1) ? 2 : 0;
  if (lead >= 0xe0 && lead <= 0xef) {
    return follows(1, lead == 0xe0 ? 0xa0 : 0x80, lead == 0xed ? 0x9f : 0xbf) && follows(2) ? 3 : 0;
  }
  if (lead >= 0xf0 && lead <= 0xf4) {
    return follows(1, lead == 0xf0 ? 0x90 : 0x80, lead == 0xf4 ? 0x8f : 0xbf) && follows(2) && follows(3) ? 4
                                                                                                          : 0;
  }
  return 0;
}

}  // namespace

std::string printable_utf8(std::string_view text, size_t max_bytes) {
  std::string out;
  while (!text.empty()) {
    const size_t length = character_length(text);
    const size_t taken = length == 0 ? 1 : length;
    if (out.size() + taken > max_bytes) break;
    const auto lead = static_cast<uint8_t>(text[0]);
    const bool control =
        lead < 0x20 || lead == 0x7f || (length == 2 && lead == 0xc2 && static_cast<uint8_t>(text[1]) < 0xa0);
    if (length == 0 || control)
      out += '?';
    else
      out += text.substr(0, length);
    text.remove_prefix(taken);
  }
  return out;
}

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c :
       // printable_utf8() does not escape quotes and backslashes.
       printable_utf8(text, text.size())) {
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

std::string plane_entries(const FrameFiles& files, const FrameImage& image) {
  std::string text;
  for (size_t i = 0; i < image.planes.size(); ++i) {
    text += (i ? "," : "") + json_string(wire::info_of(image.planes[i].output).cli_name) + ":" +
            json_string(files.planes[i].string());
  }
  return "{" + text + "}";
}

}  // namespace

std::string frame_line(const FrameFiles& files, const FrameImage& image) {
  std::string line = "{";
  if (!files.color.empty()) line += "\"file\":" + json_string(files.color.string()) + ",";
  line += "\"frame\":" + std::to_string(image.frame_index) + ",\"camera\":" + json_string(image.camera) +
          ",\"width\":" + std::to_string(image.width) + ",\"height\":" + std::to_string(image.height);
  if (!image.planes.empty()) line += ",\"planes\":" + plane_entries(files, image);
  if (image.boxes2d)
    line +=
        ",\"boxes2d\":" + list(*image.boxes2d, [](const wire::BoxRecord2d& box) { return box_entry(box); });
  if (image.boxes3d)
    line +=
        ",\"boxes3d\":" + list(*image.boxes3d, [](const wire::BoxRecord3d& box) { return box_entry(box); });
  if (image.path_traced)
    line += ",\"renderer\":\"path\",\"samples_per_pixel\":" +
            std::to_string(image.path_traced->samples_per_pixel) +
            ",\"bounces\":" + std::to_string(image.path_traced->bounces) +
            ",\"seed\":" + std::to_string(image.path_traced->seed);
  return line + ",\"streams\":" + list(image.shown, stream_entry) + "}\n";
}

}  // namespace fire3dv::sinks

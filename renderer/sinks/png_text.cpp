// PNG text chunks of an image's provenance, and their parser.
#include <charconv>
#include <cstdio>
#include <string_view>

#include "renderer/sinks/png.h"

namespace fire3dv::sinks {
namespace {

template <typename T>
void read_number(std::string_view text, T& value, int base = 10) {
  T parsed{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed, base);
  if (error == std::errc{} && end == text.data() + text.size()) value = parsed;
}

void apply_stream_field(std::string_view field, std::string_view text, state::FrameTag& tag) {
  if (field == "Stream") tag.stream = text;
  if (field == "Epoch") read_number(text, tag.epoch, 16);
  if (field == "Sequence") read_number(text, tag.sequence);
  if (field == "SimTimeNs") read_number(text, tag.sim_time_ns);
  if (field == "PublishTimeNs") read_number(text, tag.publish_time_ns);
  for (const state::Condition condition :
       {state::Condition::live, state::Condition::late, state::Condition::lost})
    if (field == "State" && text == state::condition_name(condition)) tag.condition = condition;
}

}  // namespace

std::string hex64(uint64_t value) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value));
  return digits;
}

TextChunks text_of(const FrameImage& image) {
  TextChunks text;
  text.emplace_back("Software", "FIRE-3DV " FIRE3DV_VERSION);
  if (!image.camera.empty()) text.emplace_back("Camera", image.camera);
  text.emplace_back("Frame", std::to_string(image.frame_index));
  text.emplace_back("Streams", std::to_string(image.shown.size()));
  for (size_t i = 0; i < image.shown.size(); ++i) {
    const state::FrameTag& tag = image.shown[i];
    const std::string suffix = image.shown.size() == 1 ? "" : "." + std::to_string(i);
    text.emplace_back("Stream" + suffix, tag.stream);
    text.emplace_back("Epoch" + suffix, hex64(tag.epoch));
    text.emplace_back("Sequence" + suffix, std::to_string(tag.sequence));
    text.emplace_back("SimTimeNs" + suffix, std::to_string(tag.sim_time_ns));
    text.emplace_back("PublishTimeNs" + suffix, std::to_string(tag.publish_time_ns));
    text.emplace_back("State" + suffix, state::condition_name(tag.condition));
  }
  return text;
}

void apply_text(const TextChunks& text, FrameImage& image) {
  uint64_t stream_count = 0;
  for (const auto& [keyword, value] : text) {
    if (keyword == "Camera") image.camera = value;
    if (keyword == "Frame") read_number(value, image.frame_index);
    if (keyword == "Streams") read_number(value, stream_count);
  }
  // The count is untrusted: a file cannot show more streams than it has chunks.
  image.shown.assign(stream_count <= text.size() ? stream_count : 0, {});
  for (const auto& [keyword, value] : text) {
    const std::string_view name = keyword;
    const size_t dot = name.find('.');
    size_t index = dot == std::string_view::npos ? 0 : SIZE_MAX;
    if (dot != std::string_view::npos) read_number(name.substr(dot + 1), index);
    if (index < image.shown.size()) apply_stream_field(name.substr(0, dot), value, image.shown[index]);
  }
}

}  // namespace fire3dv::sinks

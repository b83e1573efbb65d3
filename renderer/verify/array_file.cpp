#include "renderer/verify/array_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/files.h"
#include "base/numbers.h"
#include "renderer/offline/manifest.h"

namespace fire3dv::verify {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxArrayBytes = uint64_t{4} << 30, kMaxListBytes = uint64_t{1} << 30;
constexpr int kMaxNesting = 16;  // texts of JSON are made recursively

// Null: there is none.
const json* find(const json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

// Line without line feed; nullopt: it is no object, or nested too deep.
std::optional<json> parse_line(std::string_view line) {
  bool is_too_deep = false;
  const auto check_depth = [&](int depth, json::parse_event_t, json&) {
    is_too_deep |= depth > kMaxNesting;
    return !is_too_deep;
  };
  json parsed = json::parse(line.begin(), line.end(), check_depth, false);
  if (is_too_deep || !parsed.is_object()) return std::nullopt;
  return parsed;
}

bool read_stream(const json& from, state::FrameTag& tag) {
  const json *const stream = find(from, "stream"), *const epoch = find(from, "epoch"),
                    *const sequence = find(from, "sequence"), *const time = find(from, "sim_time_ns"),
                    *const condition = find(from, "state");
  if (!stream || !stream->is_string() || !epoch || !epoch->is_string() || !sequence ||
      !sequence->is_number_unsigned() || !time || !time->is_number_integer() || !condition)
    return false;
  const auto number = parse_number<uint64_t>(epoch->get<std::string>(), 16);
  if (!number) return false;
  tag.stream = stream->get<std::string>();
  tag.epoch = *number;
  tag.sequence = sequence->get<uint64_t>();
  tag.sim_time_ns = time->get<int64_t>();
  if (*condition != state::condition_name(state::Condition::live)) tag.condition = state::Condition::lost;
  return true;
}

bool read_image(const json& line, sinks::FrameImage& image) {
  const json *const frame = find(line, "frame"), *const streams = find(line, "streams");
  if (!frame || !frame->is_number_unsigned() || !streams || !streams->is_array()) return false;
  image.frame_index = frame->get<uint64_t>();
  for (const json& each : *streams) {
    if (!read_stream(each, image.shown.emplace_back())) return false;
  }
  if (const json* const hidden = find(line, "hidden_streams"); hidden && !hidden->empty())
    image.hidden_streams.emplace_back("of the list");
  if (const json* const provenance = find(line, "provenance"))
    image.run_provenance = std::make_shared<const std::string>(provenance->dump(-1, ' ', true));
  return true;
}

}  // namespace

Result<ArrayFile> read_array(const fs::path& path) {
  ArrayFile file;
  auto bytes = read_whole_file(path, kMaxArrayBytes);
  if (!bytes) return bytes.error();
  file.array.bytes = std::move(*bytes);
  // frame_000000.depth.npy
  const std::string output = path.stem().extension().string();
  const wire::ImageOutputInfo* const info =
      output.empty() ? nullptr : wire::find_image_output(std::string_view(output).substr(1));
  if (!info || info->is_boxes || info->output == wire::kMotion || info->output == wire::kOcclusionU32)
    return Error{path.string() +
                 ": only arrays of one image can be drawn again, such as frame_000000.depth.npy"};
  file.array.output = info->output;
  const fs::path list = path.parent_path() / "frames.jsonl";
  const auto text = read_whole_file(list, kMaxListBytes);
  if (!text) return text.error();
  std::string_view rest(reinterpret_cast<const char*>(text->data()), text->size());
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    const auto line = parse_line(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    const json* const planes = line ? find(*line, "planes") : nullptr;
    const json* const name = planes ? find(*planes, std::string(info->cli_name).c_str()) : nullptr;
    if (!name || *name != path.filename().string()) continue;
    if (!read_image(*line, file.image))
      return Error{list.string() + ": the line of " + path.filename().string() + " is damaged"};
    if (file.image.run_provenance) return file;
    // Of fire3dv render: the provenance of the whole folder.
    const auto manifest = offline::read_manifest(path.parent_path());
    if (manifest && *manifest && !(*manifest)->provenance.empty())
      file.image.run_provenance = std::make_shared<const std::string>((*manifest)->provenance);
    return file;
  }
  return Error{list.string() + " does not list " + path.filename().string()};
}

}  // namespace fire3dv::verify

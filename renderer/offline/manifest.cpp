#include "renderer/offline/manifest.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>

#include "base/digest.h"
#include "base/files.h"
#include "base/text.h"
#include "protocol/wire/check.h"
#include "renderer/app/options/option_values.h"

namespace fire3dv::offline {
namespace {

using nlohmann::ordered_json;

constexpr uint64_t kMaxManifestBytes = 1 << 20;
constexpr const char* kFormat = "fire3dv frames";
constexpr int kVersion = 1;
constexpr int kMaxManifestNesting = 8;
constexpr uint32_t kMaxShards = 100'000;
constexpr const char* kRecordedRate = "recorded";
constexpr size_t kMaxSettings = 64;  // look-ups are linear

std::string shown(const std::string& text) {
  return wire::printable(text.empty() ? "nothing" : text, 256);
}

std::string size_text(const Manifest& manifest) {
  return std::to_string(manifest.width) + "x" + std::to_string(manifest.height);
}

std::string rate_text(const FrameTimes& times) {
  return times.is_recorded ? kRecordedRate : to_text(times.rate);
}

// Named values that determine the bytes of frames.
std::vector<std::pair<std::string, std::string>> facts(const Manifest& manifest) {
  std::vector<std::pair<std::string, std::string>> facts = manifest.settings;
  facts.emplace_back("fps", rate_text(manifest.times));
  facts.emplace_back("the number of cameras", std::to_string(manifest.cameras));
  facts.emplace_back("size", size_text(manifest));
  facts.emplace_back("the first frame's time", std::to_string(manifest.times.first_ns) + " ns");
  facts.emplace_back("the number of frames", std::to_string(manifest.times.frames));
  return facts;
}

// Reads an integer in [least, most].
template <typename T>
bool get(const ordered_json& from, const char* name, T least, T most, T& value) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_number_integer()) return false;
  if (found->is_number_unsigned()) {
    const auto number = found->get<uint64_t>();
    if (most < 0 || number > static_cast<uint64_t>(most)) return false;
    value = static_cast<T>(number);
  } else {
    const auto number = found->get<int64_t>();
    if (number < static_cast<int64_t>(least)) return false;
    value = static_cast<T>(number);
  }
  return value >= least && value <= most;
}

bool get(const ordered_json& from, const char* name, std::string& value) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_string()) return false;
  value = found->get<std::string>();
  return true;
}

bool parse(const ordered_json& json, Manifest& manifest) {
  std::string format, rate;
  int version = 0;
  if (!json.is_object() || !get(json, "format", format) || format != kFormat ||
      !get(json, "version", kVersion, kVersion, version))
    return false;
  const auto settings = json.find("settings"), machine = json.find("machine");
  if (settings == json.end() || !settings->is_object() || machine == json.end() || !machine->is_object())
    return false;
  if (settings->size() > kMaxSettings) return false;
  for (const auto& [name, value] : settings->items()) {
    if (!value.is_string()) return false;
    manifest.settings.emplace_back(name, value.get<std::string>());
  }
  constexpr int64_t kMaxNs = int64_t{1} << 62;
  if (!get(json, "fps", rate) || !get(json, "first_ns", -kMaxNs, kMaxNs, manifest.times.first_ns) ||
      !get(json, "frames", uint64_t{1}, kMaxFrames, manifest.times.frames) ||
      !get(json, "width", 1u, app::kMaxImageSide, manifest.width) ||
      !get(json, "height", 1u, app::kMaxImageSide, manifest.height) ||
      !get(json, "shards", 1u, kMaxShards, manifest.shards) ||
      !get(json, "shard", 1u, manifest.shards, manifest.shard))
    return false;
  if (json.contains("cameras") && !get(json, "cameras", 1u, kMaxCameras, manifest.cameras)) return false;
  manifest.times.is_recorded = rate == kRecordedRate;
  if (!manifest.times.is_recorded) {
    const auto parsed = parse_frame_rate(rate);
    if (!parsed) return false;
    manifest.times.rate = *parsed;
  }
  if (const auto provenance = json.find("provenance"); provenance != json.end() && provenance->is_object())
    manifest.provenance = provenance->dump(-1, ' ', true);
  return get(*machine, "device", manifest.machine.device) &&
         get(*machine, "driver", manifest.machine.driver) && get(*machine, "cpu", manifest.machine.cpu);
}

}  // namespace

std::string setting_text(const std::string& value) {
  constexpr size_t kMaxBytes = 4000;
  std::string text = printable_text(value, kMaxBytes);
  if (text == value) return text;
  return text + " (" + hex(digest_of(std::as_bytes(std::span(value)))).substr(0, 32) + ")";
}

std::optional<std::string> difference(const Manifest& there, const Manifest& here, bool with_part) {
  const auto a = facts(there), b = facts(here);
  const auto value_of = [](const auto& all, const std::string& name) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const auto& fact) { return fact.first == name; });
    return found == all.end() ? std::string() : found->second;
  };
  for (const auto* side : {&a, &b}) {
    for (const auto& [name, value] : *side) {
      const std::string in_a = value_of(a, name), in_b = value_of(b, name);
      if (in_a != in_b)
        return wire::printable(name) + " is " + shown(in_a) + " there and " + shown(in_b) + " here";
    }
  }
  if (!with_part || (there.shard == here.shard && there.shards == here.shards)) return {};
  const auto part = [](const Manifest& m) {
    return std::to_string(m.shard) + "/" + std::to_string(m.shards);
  };
  return "the shard is " + part(there) + " there and " + part(here) + " here";
}

std::string frame_file_name(uint64_t frame) {
  char name[40];
  std::snprintf(name, sizeof name, "frame_%06llu.png", static_cast<unsigned long long>(frame));
  return name;
}

Result<std::optional<Manifest>> read_manifest(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / kManifestName;
  std::error_code fault;
  if (!std::filesystem::exists(path, fault) && !fault) return std::optional<Manifest>();
  auto bytes = read_whole_file(path, kMaxManifestBytes);
  if (!bytes) return bytes.error();
  bool is_too_deep = false;  // texts of JSON are made recursively
  const auto check_depth = [&](int depth, ordered_json::parse_event_t, ordered_json&) {
    is_too_deep |= depth > kMaxManifestNesting;
    return !is_too_deep;
  };
  const ordered_json json = ordered_json::parse(bytes->begin(), bytes->end(), check_depth, false);
  Manifest manifest;
  if (is_too_deep || json.is_discarded() || !parse(json, manifest))
    return Error{path.string() +
                 " is not what fire3dv render writes: name another folder, or remove this one"};
  return std::optional(std::move(manifest));
}

Result<void> write_manifest(const std::filesystem::path& folder, const Manifest& manifest) {
  ordered_json json;
  json["format"] = kFormat;
  json["version"] = kVersion;
  ordered_json& settings = json["settings"] = ordered_json::object();
  for (const auto& [name, value] : manifest.settings) settings[name] = printable_text(value, 4096);
  json["fps"] = rate_text(manifest.times);
  json["first_ns"] = manifest.times.first_ns;
  json["frames"] = manifest.times.frames;
  if (manifest.cameras != 1) json["cameras"] = manifest.cameras;
  json["width"] = manifest.width;
  json["height"] = manifest.height;
  json["shard"] = manifest.shard;
  json["shards"] = manifest.shards;
  json["machine"] = {{"device", printable_text(manifest.machine.device, 256)},
                     {"driver", printable_text(manifest.machine.driver, 256)},
                     {"cpu", printable_text(manifest.machine.cpu, 256)}};
  if (!manifest.provenance.empty()) json["provenance"] = ordered_json::parse(manifest.provenance);
  const std::string text = json.dump(2) + "\n";
  const auto* const first = reinterpret_cast<const uint8_t*>(text.data());
  return write_whole_file(folder / kManifestName, {first, text.size()});
}

}  // namespace fire3dv::offline

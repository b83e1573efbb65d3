#include "renderer/browser/live_inputs.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/text.h"
#include "renderer/browser/json_text.h"

namespace fire3dv::app {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxStreamNameBytes = 200;

size_t text_bytes(const std::string& name, const wire::Input& input) {
  size_t bytes = name.size() + input.unit.size() + input.text.size();
  for (const std::string& choice : input.choices) bytes += choice.size();
  return bytes;
}

Json json_of(const std::string& name, const wire::Input& input) {
  constexpr const char* kKinds[] = {"slider", "button", "toggle", "choice", "text", "run", "drag"};
  static_assert(std::size(kKinds) == wire::kInputKindCount);
  Json json = {{"name", name},
               {"kind", kKinds[static_cast<size_t>(input.kind)]},
               {"range", {input.minimum, input.maximum}},
               {"step", input.step},
               {"value", input.value},
               {"unit", input.unit},
               {"text", input.text},
               {"choices", input.choices}};
  if (input.kind == wire::InputKind::run) {
    json["speed"] = input.speed;
    const std::pair<const char*, wire::InputFlags> takes[] = {{"run", wire::kInputRunPause},
                                                              {"step", wire::kInputStep},
                                                              {"reset", wire::kInputReset},
                                                              {"speed", wire::kInputSpeed}};
    for (const auto& [action, flag] : takes) json["takes"][action] = (input.flags & flag) != 0;
  }
  return json;
}

}  // namespace

bool InputList::update(const InputRouter& router, const state::PoseState& poses) {
  const uint64_t revision = router.revision();
  if (revision == revision_) return false;
  revision_ = revision;
  Json streams = Json::array(), inputs = Json::array();
  std::vector<Entry> entries;
  uint64_t structure = 0;
  size_t bytes = 0, omitted = 0;
  for (const state::StreamId id : router.streams()) {
    const state::Stream& stream = poses.streams()[id];
    structure = 31 * structure + stream.epoch + stream.inputs().structure();
    for (const auto& [name, entry] : stream.inputs().inputs()) {
      bytes += text_bytes(name, entry.input);
      if (entries.size() == kMaxListed || bytes > kMaxTextBytes) {
        ++omitted;
        continue;
      }
      inputs.push_back(json_of(name, entry.input));
      inputs.back()["stream"] = streams.size();
      entries.push_back({stream.epoch, name});
    }
    streams.push_back(printable_text(stream.name, kMaxStreamNameBytes));
  }
  if (number_ == 0 || structure != structure_ || entries != entries_) ++number_;
  structure_ = structure;
  entries_ = std::move(entries);
  message_ = text_of({{"type", "inputs"},
                      {"list", number_},
                      {"streams", std::move(streams)},
                      {"inputs", std::move(inputs)},
                      {"omitted", omitted}});
  return true;
}

}  // namespace fire3dv::app

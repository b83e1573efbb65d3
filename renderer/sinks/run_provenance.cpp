#include "renderer/sinks/run_provenance.h"

#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "base/build_info.h"
#include "base/digest.h"
#include "base/text.h"

namespace fire3dv::sinks {
namespace {

using nlohmann::ordered_json;
using Values = RunProvenance::Values;

constexpr int kFormatVersion = 1;
constexpr int kMaxNesting = 3;
constexpr size_t kMaxValues = 4000;
constexpr size_t kMaxShownBytes = 200;

// Note of the linker in a segment of the program; empty: it has none.
std::string build_id_in(std::span<const uint8_t> notes) {
  const auto padded = [](size_t bytes) { return (bytes + 3) & ~size_t{3}; };
  while (notes.size() >= sizeof(ElfW(Nhdr))) {
    ElfW(Nhdr) head{};
    std::memcpy(&head, notes.data(), sizeof head);
    notes = notes.subspan(sizeof head);
    const size_t name_bytes = padded(head.n_namesz), value_bytes = padded(head.n_descsz);
    if (name_bytes + value_bytes > notes.size()) break;
    const bool is_gnu = head.n_namesz == 4 && std::memcmp(notes.data(), "GNU", 4) == 0;
    if (is_gnu && head.n_type == NT_GNU_BUILD_ID) return hex(notes.subspan(name_bytes, head.n_descsz));
    notes = notes.subspan(name_bytes + value_bytes);
  }
  return {};
}

// The first object is the program itself.
int read_program(dl_phdr_info* object, size_t, void* id) {
  for (size_t i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = object->dlpi_phdr[i];
    if (segment.p_type != PT_NOTE) continue;
    const auto* const begin = reinterpret_cast<const uint8_t*>(object->dlpi_addr + segment.p_vaddr);
    auto& text = *static_cast<std::string*>(id);
    if (text.empty()) text = build_id_in({begin, segment.p_memsz});
  }
  return 1;
}

ordered_json to_object(const Values& values) {
  ordered_json object = ordered_json::object();
  for (const auto& [name, value] : values) object[name] = printable_text(value, value.size());
  return object;
}

// Elements are [name, value].
ordered_json to_pairs(const Values& values) {
  ordered_json pairs = ordered_json::array();
  for (const auto& [name, value] : values) pairs.push_back({name, printable_text(value, value.size())});
  return pairs;
}

bool read_object(const ordered_json& from, const char* name, Values& values) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_object() || found->size() > kMaxValues) return false;
  for (const auto& [key, value] : found->items()) {
    if (!value.is_string()) return false;
    values.emplace_back(key, value.get<std::string>());
  }
  return true;
}

bool read_pairs(const ordered_json& from, const char* name, Values& values) {
  const auto found = from.find(name);
  if (found == from.end() || !found->is_array() || found->size() > kMaxValues) return false;
  for (const ordered_json& pair : *found) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string()) return false;
    values.emplace_back(pair[0].get<std::string>(), pair[1].get<std::string>());
  }
  return true;
}

// All values of a name, separated by commas.
std::string joined_values(const Values& values, std::string_view name) {
  std::string text;
  bool is_first = true;
  for (const auto& [key, value] : values) {
    if (key != name) continue;
    text += (is_first ? "" : ", ") + (value.empty() ? std::string("set") : value);
    is_first = false;
  }
  return is_first ? "not set" : printable_text(text, kMaxShownBytes);
}

std::vector<std::string> values_of(const Values& values, std::string_view name) {
  std::vector<std::string> all;
  for (const auto& [key, value] : values) {
    if (key == name) all.push_back(value);
  }
  return all;
}

}  // namespace

Values this_build() {
  std::string id;
  dl_iterate_phdr(read_program, &id);
  return {{"version", kVersion}, {"commit", kCommit}, {"build_id", id}};
}

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::optional<std::string> encode_provenance(const RunProvenance& provenance) {
  ordered_json json;
  json["version"] = kFormatVersion;
  json["command"] = provenance.command;
  json["build"] = to_object(provenance.build);
  json["machine"] = to_object(provenance.machine);
  json["files"] = to_object(provenance.files);
  json["inputs"] = to_object(provenance.inputs);
  json["options"] = to_pairs(provenance.options);
  std::string text = json.dump(-1, ' ', true);
  if (text.size() > kMaxProvenanceBytes) return std::nullopt;
  return text;
}

Result<RunProvenance> decode_provenance(std::string_view text) {
  if (text.size() > kMaxProvenanceBytes)
    return Error{"its provenance has " + std::to_string(text.size()) + " bytes, more than " +
                 std::to_string(kMaxProvenanceBytes)};
  bool is_too_deep = false;
  const auto check_depth = [&](int depth, ordered_json::parse_event_t, ordered_json&) {
    is_too_deep |= depth > kMaxNesting;
    return !is_too_deep;
  };
  const ordered_json json = ordered_json::parse(text.begin(), text.end(), check_depth, false);
  if (is_too_deep || json.is_discarded() || !json.is_object())
    return Error{"its provenance is not the JSON that fire3dv writes"};
  const auto version = json.find("version");
  if (version == json.end() || !version->is_number_integer())
    return Error{"its provenance has no field \"version\""};
  if (*version != kFormatVersion)
    return Error{"its provenance has another version: use the version of fire3dv that drew it"};
  RunProvenance provenance;
  const auto command = json.find("command");
  if (command == json.end() || !command->is_string()) return Error{"its provenance has no field \"command\""};
  provenance.command = command->get<std::string>();
  for (const auto& [name, values] :
       {std::pair("build", &provenance.build), std::pair("machine", &provenance.machine),
        std::pair("files", &provenance.files), std::pair("inputs", &provenance.inputs)}) {
    if (!read_object(json, name, *values))
      return Error{std::string("its provenance has no field \"") + name + "\" with texts"};
  }
  if (!read_pairs(json, "options", provenance.options))
    return Error{"its provenance has no field \"options\" with pairs of texts"};
  return provenance;
}

const std::string* find_value(const Values& values, std::string_view name) {
  const auto found =
      std::find_if(values.begin(), values.end(), [&](const auto& value) { return value.first == name; });
  return found == values.end() ? nullptr : &found->second;
}

std::optional<std::string> first_difference(const Values& in_file, const Values& here) {
  for (const Values* const side : {&in_file, &here}) {
    for (const auto& [name, value] : *side) {
      if (values_of(in_file, name) == values_of(here, name)) continue;
      return printable_text(name, kMaxShownBytes) + " is " + joined_values(in_file, name) +
             " in the file and " + joined_values(here, name) + " here";
    }
  }
  return std::nullopt;
}

}  // namespace fire3dv::sinks

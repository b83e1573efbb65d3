#include "protocol/import/lerobot/lerobot_set.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "protocol/record/mcap/file.h"

namespace fire3dv::imported {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr uint64_t kMaxInfoBytes = 4 << 20;
constexpr size_t kMaxNames = 4096, kMaxNameBytes = 255;
constexpr double kMaxIndex = 1e6;  // of chunks and files

// Names do not follow from the set's own patterns: those could name files of others.
fs::path numbered(const char* pattern, uint64_t chunk, uint64_t file) {
  char name[80];
  std::snprintf(name, sizeof name, pattern, static_cast<unsigned long long>(chunk),
                static_cast<unsigned long long>(file));
  return name;
}
constexpr const char* kEpisodesPattern = "meta/episodes/chunk-%03llu/file-%03llu.parquet";
constexpr const char* kDataPattern = "data/chunk-%03llu/file-%03llu.parquet";
constexpr const char* kEpisodePattern = "data/chunk-%03llu/episode_%06llu.parquet";

Result<ParquetFile> open_table(const fs::path& path) {
  auto source = record::open_source(path.string());
  if (!source) return source.error();
  return ParquetFile::open(std::move(*source));
}

// Of lists in objects, too: version 2 has {"motors": [...]}.
bool add_names(const ordered_json& names, std::vector<std::string>& out) {
  if (names.is_string()) {
    const auto& name = names.get_ref<const std::string&>();
    if (out.size() == kMaxNames || name.size() > kMaxNameBytes) return false;
    out.push_back(name);
    return true;
  }
  if (!names.is_array() && !names.is_object()) return names.is_null();
  for (const auto& each : names) {
    if (!each.is_string() && !(names.is_object() && each.is_array())) return false;
    if (!add_names(each, out)) return false;
  }
  return true;
}

std::optional<uint64_t> count_at(const ordered_json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_number_unsigned()) return std::nullopt;
  return found->get<uint64_t>();
}

Result<std::optional<std::pair<uint64_t, uint64_t>>> find_data_file(const fs::path& path, uint64_t episode) {
  auto table = open_table(path);
  if (!table) return table.error();
  for (size_t group = 0; group < table->row_groups(); ++group) {
    const auto index = table->read_numbers(group, "episode_index");
    if (!index) return index.error();
    for (size_t row = 0; row < index->values.size(); ++row) {
      if (index->values[row] != static_cast<double>(episode)) continue;
      const auto chunk = table->read_numbers(group, "data/chunk_index"),
                 file = table->read_numbers(group, "data/file_index");
      for (const auto* numbers : {&chunk, &file}) {
        if (!*numbers) return numbers->error();
        const double number = row < (*numbers)->values.size() ? (*numbers)->values[row] : -1;
        if (!(number >= 0 && number < kMaxIndex))
          return Error{quote(path.string()) + ": episode " + std::to_string(episode) + " names no data file"};
      }
      return std::optional(
          std::pair(static_cast<uint64_t>(chunk->values[row]), static_cast<uint64_t>(file->values[row])));
    }
  }
  return std::optional<std::pair<uint64_t, uint64_t>>();
}

// Data file of an episode of version 3, from meta/episodes.
Result<fs::path> find_episode(const fs::path& folder, uint64_t episode) {
  for (uint64_t chunk = 0;; ++chunk) {
    uint64_t file = 0;
    std::error_code fault;
    for (;; ++file) {
      const fs::path path = folder / numbered(kEpisodesPattern, chunk, file);
      if (!fs::exists(path, fault)) break;
      const auto found = find_data_file(path, episode);
      if (!found) return found.error();
      if (*found) return folder / numbered(kDataPattern, (*found)->first, (*found)->second);
    }
    if (file == 0)
      return Error{quote((folder / "meta/episodes").string()) + " has no episode " + std::to_string(episode)};
  }
}

}  // namespace

Result<LerobotInfo> read_lerobot_info(const fs::path& folder) {
  const fs::path path = folder / "meta/info.json";
  const auto text = read_whole_file(path, kMaxInfoBytes);
  if (!text) return text.error();
  const auto fault = [&](const std::string& what) { return Error{quote(path.string()) + ": " + what}; };
  const auto json = ordered_json::parse(text->begin(), text->end(), nullptr, false);
  if (!json.is_object()) return fault("it is no JSON object");
  LerobotInfo info;
  const auto version = json.find("codebase_version");
  const std::string named = version != json.end() && version->is_string() ? version->get<std::string>() : "";
  if (named.starts_with("v2."))
    info.version = 2;
  else if (!named.starts_with("v3."))
    return fault("version " + quote(named) + " is not read; v2.0, v2.1 and v3.0 are");
  const auto fps = json.find("fps");
  if (fps != json.end() && fps->is_number()) info.fps = fps->get<double>();
  if (!(info.fps >= 1e-3 && info.fps <= 1e6)) return fault("fps is no number from 0.001 to 1000000");
  const auto episodes = count_at(json, "total_episodes");
  if (!episodes) return fault("total_episodes is missing");
  info.episodes = *episodes;
  info.chunk_files = count_at(json, "chunks_size").value_or(info.chunk_files);
  if (info.chunk_files == 0) return fault("chunks_size is 0");
  const auto features = json.find("features");
  const auto state =
      features != json.end() && features->is_object() ? features->find(kStateColumn) : json.end();
  if (features == json.end() || !features->is_object() || state == features->end() || !state->is_object())
    return fault("it has no feature " + quote(kStateColumn) + ", whose joint positions are read");
  const auto names = state->find("names");
  if (names != state->end() && !add_names(*names, info.state_names))
    return fault("the names of " + quote(kStateColumn) + " are no list of texts");
  return info;
}

Result<EpisodeRows> read_episode(const fs::path& folder, const LerobotInfo& info, uint64_t episode) {
  auto path = info.version == 2
                  ? Result<fs::path>(folder / numbered(kEpisodePattern, episode / info.chunk_files, episode))
                  : find_episode(folder, episode);
  if (!path) return path.error();
  auto table = open_table(*path);
  if (!table) return table.error();
  EpisodeRows rows;
  const auto fault = [&](const std::string& what) { return Error{quote(path->string()) + ": " + what}; };
  for (size_t group = 0; group < table->row_groups(); ++group) {
    const auto owner = table->read_numbers(group, "episode_index");
    if (!owner) return owner.error();
    const auto is_own = [&](size_t row) { return owner->values[row] == static_cast<double>(episode); };
    bool has_any = false;
    for (size_t row = 0; row < owner->values.size() && !has_any; ++row) has_any = is_own(row);
    if (!has_any) continue;
    const auto frames = table->read_numbers(group, "frame_index"),
               state = table->read_numbers(group, kStateColumn);
    if (!frames) return frames.error();
    if (!state) return state.error();
    if (rows.state.width == 0) rows.state.width = state->width;
    if (state->width != rows.state.width || owner->width != 1 || frames->width != 1 || state->width == 0)
      return fault("columns have other lengths in some rows");
    for (size_t row = 0; row < owner->values.size(); ++row) {
      if (!is_own(row)) continue;
      if (rows.state.values.size() + state->width > ParquetFile::kMaxNumbers)
        return fault("episode " + std::to_string(episode) + " has more than " +
                     std::to_string(ParquetFile::kMaxNumbers) + " numbers");
      rows.frame_index.push_back(frames->values[row]);
      const auto first = state->values.begin() + static_cast<std::ptrdiff_t>(row * state->width);
      rows.state.values.insert(rows.state.values.end(), first,
                               first + static_cast<std::ptrdiff_t>(state->width));
    }
  }
  if (rows.frame_index.empty()) return fault("it has no row of episode " + std::to_string(episode));
  return rows;
}

}  // namespace fire3dv::imported

#include "renderer/offline/drawing_words.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/command_line.h"
#include "base/numbers.h"

namespace fire3dv::offline {
namespace {

constexpr int kUsageError = 2;
constexpr uint32_t kMaxShards = 100'000;

// Renderer options that do not affect pixels, and those that the manifest stores otherwise.
constexpr std::array kMachineWithValue{"--cache", "--device", "--devices", "--async-compute", "--checkpoint"};
constexpr std::array kOtherwiseStored{"--size", "--environment", "--overlay"};
constexpr std::array kNeutralFlags{"--validation", "--no-validation", "--headless", "--require-gpu"};

template <typename List>
bool contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

std::string look_of(const std::vector<std::string>& words, const std::string& scene) {
  std::string look;
  bool scene_seen = scene.empty();
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    const std::string_view name = word.substr(0, word.find('='));
    if (contains(kMachineWithValue, name) || contains(kOtherwiseStored, name)) {
      if (name == word) ++i;
    } else if (!contains(kNeutralFlags, word)) {
      if (!scene_seen && word == scene) {
        scene_seen = true;
        continue;
      }
      look += (look.empty() ? "" : " ") + words[i];
    }
  }
  std::replace(look.begin(), look.end(), '=', ' ');
  return look;
}

std::string for_live_streams(const std::string& option) {
  return option + " is for streams that are live; a recording is rendered without";
}

// Rejects options for which the renderer's parser has no or a misleading error.
std::optional<std::string> check_words(std::string_view command, const std::vector<std::string>& words) {
  constexpr std::array kLive{"--play", "--delay", "--mark-held", "--on-request"};
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (contains(kLive, name)) return for_live_streams(name);
    if (name == "--outputs" && command == "dataset")
      return "--outputs: --format decides which labels are drawn";
  }
  return {};
}

// Rejects renderer options that have no meaning offline.
std::optional<std::string> check_drawing(const app::Options& drawing) {
  const auto none = for_live_streams;
  if (!drawing.listen.empty()) return none("--listen");
  if (!drawing.recording.replay.empty() || !drawing.recording.streams.empty() || drawing.recording.loop)
    return "--replay, --stream and --loop are for watching a recording; the one to render is named first";
  if (!drawing.recording.record.empty()) return none("--record");
  if (drawing.lockstep) return none("--lockstep");
  if (!drawing.metrics.empty()) return none("--metrics");
  if (!drawing.serve.empty()) return none("--serve");
  if (drawing.exit_when_done) return none("--exit-when-done");
  if (drawing.frames != 0) return "--frames: choose a part with --start and --end";
  if (!drawing.stats.empty()) return none("--stats");
  if (drawing.list_devices) return "--list-devices is an option of fire3dv alone";
  return {};
}

}  // namespace

int usage_error(const char* command, const std::string& text) {
  std::cerr << "fire3dv " << command << ": error: " << text << " (see fire3dv " << command << " --help)\n";
  return kUsageError;
}

Words split_words(int argc, char** argv, std::span<const char* const> with_value,
                  std::span<const char* const> flags) {
  Words words;
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i];
    const std::string_view name = word.substr(0, word.find('='));
    const bool has_value = contains(with_value, name);
    if (!has_value && !contains(flags, word)) {
      words.rest.emplace_back(word);
      continue;
    }
    words.own.emplace_back(word);
    if (has_value && name == word && i + 1 < argc) words.own.emplace_back(argv[++i]);
  }
  return words;
}

std::optional<int> parse_own_words(CLI::App& app, const char* command, const Words& words) {
  try {
    std::vector<std::string> reversed(words.own.rbegin(), words.own.rend());
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return usage_error(command, usage_text(app, error));
  }
  return std::nullopt;
}

sinks::RunProvenance::Values stored_options(const std::vector<std::string>& own,
                                            std::span<const char* const> with_value,
                                            bool (*is_stored)(std::string_view name)) {
  sinks::RunProvenance::Values stored;
  for (size_t i = 0; i < own.size(); ++i) {
    const std::string_view word = own[i];
    const size_t equals = word.find('=');
    const std::string_view option = word.substr(0, equals);
    std::string value = equals == std::string_view::npos ? std::string() : own[i].substr(equals + 1);
    if (equals == std::string_view::npos && contains(with_value, option) && i + 1 < own.size())
      value = own[++i];
    if (option.starts_with("--") && is_stored(option.substr(2)))
      stored.emplace_back(option.substr(2), std::move(value));
  }
  return stored;
}

std::vector<std::string> without_machine_options(std::span<const std::string> words) {
  std::vector<std::string> kept;
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    const std::string_view name = word.substr(0, word.find('='));
    if (contains(kMachineWithValue, name))
      i += name == word;
    else if (!contains(kNeutralFlags, word))
      kept.push_back(words[i]);
  }
  return kept;
}

std::variant<Drawing, int> parse_drawing(const char* command, char* program, std::vector<std::string> words) {
  if (const auto wrong = check_words(command, words)) return usage_error(command, *wrong);
  std::vector<char*> arguments{program};
  for (std::string& word : words) arguments.push_back(word.data());
  auto parsed = app::parse_options(static_cast<int>(arguments.size()), arguments.data(), false);
  if (const int* exit_code = std::get_if<int>(&parsed)) return *exit_code;
  Drawing drawing;
  drawing.options = std::move(std::get<app::Options>(parsed));
  drawing.options.headless = true;
  if (const auto wrong = check_drawing(drawing.options)) return usage_error(command, *wrong);
  drawing.look = look_of(words, drawing.options.scene.string());
  return drawing;
}

bool parse_shard(const std::string& text, uint32_t& index, uint32_t& count) {
  const auto parts = parse_pair<uint32_t>(text, '/');
  if (!parts) return false;
  std::tie(index, count) = *parts;
  return index >= 1 && index <= count && count <= kMaxShards;
}

std::optional<std::string> check_range(double start_s, const std::optional<double>& end_s) {
  constexpr double kMaxSeconds = 1e9;
  if (!(start_s >= 0 && start_s <= kMaxSeconds)) return "--start must be a number from 0 to 1e9";
  if (end_s && !(*end_s >= start_s && *end_s <= kMaxSeconds))
    return "--end must be a number from that of --start to 1e9";
  return {};
}

}  // namespace fire3dv::offline

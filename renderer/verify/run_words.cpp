#include "renderer/verify/run_words.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "renderer/app/options/appearance_options.h"
#include "renderer/dataset/options.h"
#include "renderer/offline/commands.h"

namespace fire3dv::verify {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxShownBytes = 200;
constexpr std::array<std::string_view, 4> kFlagNames{"frame-all", "frame-motion", "full-chroma",
                                                     "stereo-pairs"};

bool may_be_used(const std::string& command, std::string_view option) {
  if (app::is_appearance_option(option)) return true;
  if (command == "render") return offline::is_stored_option(option);
  return command == "dataset" && dataset::is_stored_option(option);
}

// Regular file of this name in the folder; empty: there is none.
fs::path file_beside(const fs::path& folder, const std::string* name) {
  if (!name || name->empty() || fs::path(*name).filename() != *name) return {};
  std::error_code fault;
  const fs::path path = (folder.empty() ? fs::path(".") : folder) / *name;  // never an option of the run
  return fs::is_regular_file(fs::symlink_status(path, fault)) ? path : fs::path();
}

Error missing(const VerifyOptions& options, const char* what, const std::string* name) {
  return Error{"the " + std::string(what) + (name ? " " + quote(printable_text(*name, kMaxShownBytes)) : "") +
               " that was drawn is not named: fire3dv verify " + options.target.string() +
               (std::string_view(what) == "scene" ? " [RECORDING.mcap] SCENE" : " RECORDING.mcap [SCENE]")};
}

}  // namespace

Result<Inputs> find_inputs(const VerifyOptions& options, const fs::path& folder,
                           const sinks::RunProvenance& provenance, bool needs_recording) {
  Inputs inputs{options.recording, options.scene};
  const std::string* const recording = sinks::find_value(provenance.files, "recording");
  const std::string* const scene = sinks::find_value(provenance.files, "scene");
  if (recording || needs_recording) {
    if (inputs.recording.empty()) inputs.recording = file_beside(folder, recording);
    if (inputs.recording.empty()) return missing(options, "recording", recording);
  } else {
    inputs.recording.clear();
  }
  if (inputs.scene.empty()) inputs.scene = file_beside(folder, scene);
  if (inputs.scene.empty() && scene) return missing(options, "scene", scene);
  return inputs;
}

Result<std::vector<std::string>> words_of_run(const sinks::RunProvenance& provenance, const Inputs& inputs,
                                              const std::vector<std::string>& user_words,
                                              const std::string& out) {
  std::vector<std::string> words;
  const bool has_command = provenance.command == "render" || provenance.command == "dataset";
  if (!has_command && provenance.command != "fire3dv")
    return Error{"its provenance names the command " +
                 quote(printable_text(provenance.command, kMaxShownBytes)) +
                 ", which this version cannot repeat"};
  const auto has_word = [&](const std::string& option) {
    return std::any_of(user_words.begin(), user_words.end(),
                       [&](const std::string& word) { return word.substr(0, word.find('=')) == option; });
  };
  // Files are never taken from the image, but its seed needs the file.
  if (sinks::find_value(provenance.inputs, "randomization") && !has_word("--randomize"))
    return Error{"it was drawn with --randomize FILE.yaml: repeat that option, and --draws if there was one"};
  if (has_command) words = {provenance.command, "--out=" + out};
  // Names come first: the commands expect the recording there.
  const auto add_input = [&](const fs::path& path) {
    if (!path.empty()) words.insert(words.end() - (has_command ? 1 : 0), path.string());
  };
  if (has_command) add_input(inputs.recording);
  add_input(inputs.scene);
  for (const auto& [name, value] : provenance.options) {
    if (!may_be_used(provenance.command, name))
      return Error{"its provenance has the option " + quote("--" + printable_text(name, kMaxShownBytes)) +
                   ", which an image cannot set"};
    const std::string option = "--" + name;
    if (has_word(option)) continue;
    const bool is_flag = std::find(kFlagNames.begin(), kFlagNames.end(), name) != kFlagNames.end();
    words.push_back(is_flag ? option : option + "=" + value);
  }
  words.insert(words.end(), user_words.begin(), user_words.end());
  return words;
}

}  // namespace fire3dv::verify

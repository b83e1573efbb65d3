#include "renderer/offline/inputs/input_kind.h"

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "base/files.h"
#include "base/words.h"
#include "renderer/loading/converted_scene.h"

namespace fire3dv::offline {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr std::string_view kMcap = "\x89MCAP0\r\n"sv, kHdf5 = "\x89HDF\r\n\x1a\n"sv,
                           kSqlite = "SQLite format 3"sv;

// Empty: no regular file.
std::string first_bytes(const fs::path& path) {
  std::array<char, 16> bytes{};
  std::error_code fault;
  if (!fs::is_regular_file(path, fault)) return {};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<size_t>(file.gcount())};
}

// Names, as far as they come before the options.
std::vector<std::string> leading_names(const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const std::string& word : words) {
    if (word.empty() || word.starts_with('-')) break;
    names.push_back(word);
  }
  return names;
}

}  // namespace

bool is_recording(const fs::path& path) {
  return lower_extension(path) == ".mcap" || first_bytes(path).starts_with(kMcap);
}

InputKind find_input_kind(const fs::path& path) {
  if (is_recording(path)) return InputKind::recording;
  std::error_code fault;
  if (fs::is_directory(path, fault) &&
      (fs::exists(path / "metadata.yaml", fault) || fs::exists(path / "meta/info.json", fault)))
    return InputKind::states;
  const std::string begin = first_bytes(path);
  if (begin.starts_with(kHdf5) || begin.starts_with(kSqlite)) return InputKind::states;
  const std::string extension = lower_extension(path);
  if (extension == ".glb" || extension == ".gltf" || app::needs_conversion(path)) return InputKind::scene;
  return InputKind::unknown;
}

std::optional<std::string> find_wrong_inputs(const std::string& command,
                                             const std::vector<std::string>& words) {
  const std::vector<std::string> names = leading_names(words);
  if (names.empty()) return std::nullopt;
  const bool takes_states = command == "relabel";
  const InputKind first = find_input_kind(names[0]);
  const InputKind second = names.size() > 1 ? find_input_kind(names[1]) : InputKind::unknown;
  const bool is_second_first =
      second == InputKind::recording || (takes_states && second == InputKind::states);
  if (first == InputKind::scene && is_second_first)
    return "the recording comes first, then the scene: fire3dv " + command + " " + shell_word(names[1]) +
           " " + shell_word(names[0]);
  for (size_t i = 0; i < names.size() && !takes_states; ++i) {
    if ((i == 0 ? first : find_input_kind(names[i])) == InputKind::states)
      return names[i] + " holds states of another program, which fire3dv relabel draws: fire3dv relabel " +
             shell_word(names[i]) + " SCENE --format FORMAT --out DIR";
  }
  if (command == "render" && first == InputKind::scene)
    return names[0] +
           " is a scene, and no recording: fire3dv dataset draws scenes at rest with labels, and "
           "fire3dv SCENE --headless --out DIR draws one image";
  if (takes_states && first == InputKind::scene && second != InputKind::unknown)
    return names[0] + " is a scene: name the recording first: fire3dv relabel STATES SCENE";
  return std::nullopt;
}

}  // namespace fire3dv::offline

// Files that the panel Edit offers, as URIs of an overlay file.

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/text.h"
#include "renderer/editing/new_objects.h"
#include "renderer/scene/files.h"

namespace fire3dv::app {
namespace {

namespace fs = std::filesystem;

// Names of files are bytes; a URI in an overlay file is UTF-8, and neither begins with a scheme.
std::string to_uri(std::string_view relative) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string uri = relative.substr(0, relative.find('/')).find(':') == std::string_view::npos ? "" : "./";
  for (size_t at = 0; at < relative.size();) {
    const size_t begin = at;
    const uint32_t character = next_character(relative, at);
    const bool is_plain =
        character != kInvalidCharacter && !is_control(character) && character != '%' && character != ':';
    for (const char byte : relative.substr(begin, at - begin)) {
      if (is_plain)
        uri += byte;
      else
        uri += {'%', kDigits[static_cast<uint8_t>(byte) >> 4], kDigits[static_cast<uint8_t>(byte) & 15]};
    }
  }
  return uri;
}

void list_assets(const fs::path& folder, std::set<std::string>& uris) {
  constexpr size_t kMaxLooked = 10'000;
  constexpr int kMaxDepth = 1;
  const scene::AssetFolder readable(folder / "scene");
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
  for (size_t looked = 0; !error && entry != fs::recursive_directory_iterator() && looked < kMaxLooked;
       entry.increment(error), ++looked) {
    if (entry.depth() >= kMaxDepth) entry.disable_recursion_pending();
    const std::string ending = entry->path().extension().string();
    std::error_code fault;
    if ((ending != ".glb" && ending != ".gltf") || !entry->is_regular_file(fault)) continue;
    std::string uri = to_uri(entry->path().lexically_relative(folder).generic_string());
    // No link that leads out, and no backslash.
    if (readable.resolve(uri)) uris.insert(std::move(uri));
  }
}

}  // namespace

std::vector<std::string> offered_assets(const fs::path& overlay, const fs::path& assets) {
  constexpr size_t kMaxAssets = 200;
  std::set<std::string> uris;  // one that both folders have is the overlay file's
  const fs::path folder = overlay.parent_path();
  if (!overlay.empty()) list_assets(folder.empty() ? "." : folder, uris);
  if (!assets.empty()) list_assets(assets, uris);
  std::vector<std::string> offered(uris.begin(), uris.end());
  if (offered.size() > kMaxAssets) offered.resize(kMaxAssets);
  return offered;
}

std::string name_of_asset(std::string_view uri) {
  constexpr size_t kMaxBytes = 255;
  const std::string stem = fs::path(uri).stem().string();
  std::string bytes;
  for (size_t at = 0; at < stem.size(); ++at) {
    uint8_t byte = 0;
    const char* const digits = stem.data() + at + 1;
    const bool is_escape = stem[at] == '%' && stem.size() - at > 2 &&
                           std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
    bytes += is_escape ? static_cast<char>(byte) : stem[at];
    if (is_escape) at += 2;
  }
  return printable_text(bytes, kMaxBytes);
}

}  // namespace fire3dv::app

#include "convert/description_files.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <regex>
#include <span>
#include <system_error>

#include "renderer/scene/files.h"
#include "renderer/scene/gltf/foreign_file.h"

namespace fire3dv::convert {

namespace {

bool is_below(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

Result<std::filesystem::path> regular_file(const std::filesystem::path& path) {
  const std::string name = quote(path.string());
  if (path.native().find('\0') != std::string::npos) return Error{"the path " + name + " holds a zero byte"};
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::canonical(path, error);
  if (error) return Error{"cannot open " + name + ": " + error.message()};
  for (const char* made_up : {"/proc", "/sys", "/dev"}) {
    if (is_below(made_up, resolved)) return Error{name + " is not a file on a disk"};
  }
  const std::filesystem::file_status status = std::filesystem::status(resolved, error);
  if (error) return Error{"cannot open " + name + ": " + error.message()};
  if (!std::filesystem::is_regular_file(status)) {
    return Error{name + (std::filesystem::is_directory(status) ? " is a folder" : " is not a regular file")};
  }
  return resolved;
}

std::optional<Error> git_lfs_pointer(const std::filesystem::path& file) {
  constexpr std::string_view kBegin = "version https://git-lfs";
  std::array<char, kBegin.size()> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), head.size());
  if (!in || std::string_view(head.data(), head.size()) != kBegin) return std::nullopt;
  return Error{"it is a pointer of Git LFS, not the file itself: fetch that with git lfs pull"};
}

Result<FileBytes> read_asset(const std::filesystem::path& file, uint64_t max_bytes) {
  if (std::optional<Error> pointer = git_lfs_pointer(file)) return *std::move(pointer);
  return read_file(file, max_bytes);
}

std::filesystem::path tidy_path(const std::filesystem::path& path) {
  std::filesystem::path tidy;
  for (const std::filesystem::path& part : path)
    if (part != ".") tidy /= part;
  return tidy;
}

void AllowedFolders::add(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path resolved =
      std::filesystem::canonical(folder.empty() ? std::filesystem::path(".") : folder, error);
  if (error || resolved == resolved.root_path()) return;
  if (std::find(folders_.begin(), folders_.end(), resolved) == folders_.end()) folders_.push_back(resolved);
}

void AllowedFolders::add(const AllowedFolders& others) {
  for (const std::filesystem::path& folder : others.folders_) add(folder);
}

bool AllowedFolders::hold(const std::filesystem::path& resolved) const {
  return std::any_of(folders_.begin(), folders_.end(),
                     [&](const std::filesystem::path& folder) { return is_below(folder, resolved); });
}

namespace {

constexpr uint64_t kMaxBytes = uint64_t{64} << 20;
constexpr int kMaxDepth = 100;
constexpr std::string_view kSpace = " \t\r\n";

size_t line_of(std::string_view text, size_t at) {
  return 1 + static_cast<size_t>(std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(at), '\n'));
}

// Returns the position behind `closing`; npos if it is missing.
size_t end_of(std::string_view text, size_t at, std::string_view closing) {
  const size_t end = text.find(closing, at);
  return end == std::string_view::npos ? end : end + closing.size();
}

// Returns the end of a tag, skipping '>' in quoted attribute values.
size_t end_of_tag(std::string_view text, size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at + 1;
    }
  }
  return std::string_view::npos;
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

// Returns true where a UTF-8 lead byte would swallow markup. Parsers trust its length, even across a quote or
// '<'.
bool hides_markup(std::string_view text) {
  for (size_t i = 0; i < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const size_t more = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : lead >= 0xc0 ? 1 : 0;
    for (size_t k = 1; k <= more; ++k)
      if (i + k >= text.size() || static_cast<unsigned char>(text[i + k]) < 0x80) return true;
  }
  return false;
}

// Returns the end of an XML declaration that all parsers agree on; npos: none.
size_t end_of_declaration(std::string_view text, size_t at) {
  static const std::regex form(
      R"(<\?xml(\s+(version|encoding|standalone)\s*=\s*("[\w.-]*"|'[\w.-]*'))*\s*\?>)");
  constexpr size_t kLongest = 200;
  const size_t end = end_of(text, at, ">");
  const bool is_short = end != std::string_view::npos && end - at <= kLongest;
  return is_short && std::regex_match(std::string(text.substr(at, end - at)), form) ? end
                                                                                    : std::string_view::npos;
}

bool has_key(std::string_view text, std::string_view key) {
  for (size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    const bool first_of_line = at == 0 || text[at - 1] == '\n';
    const size_t colon = text.find_first_not_of(" \t", at + key.size());
    if (first_of_line && colon != std::string_view::npos && text[colon] == ':') return true;
  }
  return false;
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  const auto* first = reinterpret_cast<const char*>(bytes->data.get());
  std::string text(first, bytes->size);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // UTF-8 byte order mark
  return text;
}

std::string_view without_extra_ends(std::string_view text) {
  constexpr std::string_view kEnd = "</mujoco>";
  for (;;) {
    const std::string_view whole = text.substr(0, text.find_last_not_of(kSpace) + 1);  // npos + 1 is 0
    if (!whole.ends_with(kEnd)) return text;
    std::string_view before = whole.substr(0, whole.size() - kEnd.size());
    before = before.substr(0, before.find_last_not_of(kSpace) + 1);
    if (!before.ends_with(kEnd)) return text;
    text = before;
  }
}

// Parsers differ on where unusual constructs end. Text inside a comment for one parser would be elements for
// another, so only constructs that all parsers read alike are accepted.
namespace {

// Parsers compare each attribute of an element with all before it.
constexpr size_t kMaxAttributes = 1000;

// Number of quoted values in a tag.
size_t count_values(std::string_view tag) {
  size_t count = 0;
  for (size_t at = tag.find_first_of("\"'"); at != std::string_view::npos;
       at = tag.find_first_of("\"'", at + 1)) {
    at = tag.find(tag[at], at + 1);
    if (at == std::string_view::npos) break;
    ++count;
  }
  return count;
}

}  // namespace

Result<std::string> xml_root(std::string_view text) {
  text = without_extra_ends(text);
  std::string root;
  int depth = 0;
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos || text[first] != '<') return root;
  for (size_t at = first; at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    const size_t begin = at;
    const auto refuse = [&](const std::string& why) {
      return Error{"line " + std::to_string(line_of(text, begin)) + ": " + why};
    };
    if (rest.starts_with("<!--")) {
      at = end_of(text, at + 4, "-->");
    } else if (rest.starts_with("<?")) {
      at = at == first ? end_of_declaration(text, at) : std::string_view::npos;
      if (at == std::string_view::npos)
        return refuse(
            "only <?xml version=\"1.0\"?> is read of what begins with '<?', and that only as the first");
      std::string declaration(text.substr(begin, at - begin));
      for (char& c : declaration) c = static_cast<char>(c | 0x20);  // ASCII lower case
      const bool is_utf8 =
          declaration.find("encoding") == std::string::npos || declaration.find("utf") != std::string::npos;
      if (is_utf8 && hides_markup(text)) return refuse("the file is not in UTF-8: save it as that");
    } else if (rest.starts_with("<![CDATA[")) {
      at = end_of(text, at, "]]>");
    } else if (rest.starts_with("<!")) {
      at = end_of(text, at, ">");
      const std::string_view declaration = text.substr(begin, at == std::string_view::npos ? at : at - begin);
      if (declaration.find('[') != std::string_view::npos || declaration.starts_with("<!ENTITY"))
        return refuse("it defines entities, which descriptions do without: write out what they stand for");
      if (!declaration.starts_with("<!DOCTYPE") || declaration.find_first_of("\"'") != std::string_view::npos)
        return refuse("take out what begins here with '<!': descriptions do without");
    } else if (rest.starts_with("</")) {
      at = end_of(text, at, ">");
      const std::string_view tag = text.substr(begin, at == std::string_view::npos ? at : at - begin);
      if (--depth < 0 || tag.find_first_of("\"'") != std::string_view::npos)
        return refuse("the end of an element that has not begun");
    } else {
      at = end_of_tag(text, at);
      const bool whole = at != std::string_view::npos;
      const std::string_view tag = text.substr(begin + 1, whole ? at - begin - 2 : 0);
      if (rest.size() < 2 || !is_letter(rest[1]))
        return refuse("'<' stands before no name; as text it is &lt;");
      if (root.empty()) root = tag.substr(0, tag.find_first_of(" \t\r\n/"));
      if (count_values(tag) > kMaxAttributes)
        return refuse("an element with more than " + std::to_string(kMaxAttributes) + " attributes");
      if (!tag.ends_with('/') && ++depth > kMaxDepth)
        return refuse("more than " + std::to_string(kMaxDepth) + " elements inside each other");
    }
    if (at == std::string_view::npos) return refuse("what begins here with '<' has no end");
  }
  return root;
}

Result<DescriptionKind> kind_of(const std::filesystem::path& file, std::string_view text) {
  const std::string name = quote(file.string());
  if (text.starts_with("glTF")) return Error{name + " is glTF already: give it to fire3dv as it is"};
  const auto bytes = std::as_bytes(std::span(text));
  const std::optional<scene::FileFormat> other = scene::foreign_format(bytes, file);
  if (text.find('\0') != std::string_view::npos) {
    return Error{other && !other->name.empty() ? name + " is " + other->name + ": " + other->remedy
                                               : name + " is not text: a description is YAML or XML"};
  }
  const Result<std::string> root = xml_root(text);
  if (!root) return Error{name + ": " + root.error().message};
  if (*root == "mujoco" || *root == "mujocoinclude") return DescriptionKind::mjcf;
  if (*root == "robot") return DescriptionKind::urdf;
  if (*root == "sdf") return DescriptionKind::sdf;
  if (*root == "gazebo")
    return Error{name + " is SDF of before version 1.3, which is not read: convert it with Gazebo Classic"};
  if (!root->empty()) {
    return Error{name + " is XML of the kind " + quote(*root) +
                 ": <robot> (URDF), <mujoco> (MJCF) and <sdf> (SDF) are read"};
  }
  for (const std::string_view key : {"multibody configs", "world config", "bodies", "lights", "cameras",
                                     "environment", "soft bodies", "ghost objects", "joints", "volumes"})
    if (has_key(text, key)) return DescriptionKind::adf;
  if (other && !other->name.empty()) return Error{name + " is " + other->name + ": " + other->remedy};
  return Error{name +
               " is not a supported description file: an AMBF file (YAML with bodies, multibody configs, or "
               "a world's lights and cameras), URDF, MJCF or SDF"};
}

}  // namespace fire3dv::convert

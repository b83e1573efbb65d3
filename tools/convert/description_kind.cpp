#include "tools/convert/description_kind.h"

#include <algorithm>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMostBytes = uint64_t{64} << 20;
constexpr int kMostDepth = 100;
constexpr std::string_view kSpace = " \t\r\n";

size_t line_of(std::string_view text, size_t at) {
  return 1 + static_cast<size_t>(std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(at), '\n'));
}

// Where what begins at `at` with `opening` is over; npos if it is not.
size_t end_of(std::string_view text, size_t at, std::string_view closing) {
  const size_t end = text.find(closing, at);
  return end == std::string_view::npos ? end : end + closing.size();
}

// The end of a tag: a '>' in an attribute's value is none.
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
  const Result<scene::Bytes> bytes = scene::read_file(file, kMostBytes);
  if (!bytes) return bytes.error();
  const auto* first = reinterpret_cast<const char*>(bytes->data.get());
  std::string text(first, bytes->size);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // some editors' mark of UTF-8
  return text;
}

Result<std::string> xml_root(std::string_view text) {
  std::string root;
  int depth = 0;
  size_t at = text.find_first_not_of(kSpace);
  if (at == std::string_view::npos || text[at] != '<') return root;
  for (at = text.find('<', at); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    const size_t begin = at;
    if (rest.starts_with("<!--")) {
      at = end_of(text, at + 4, "-->");
    } else if (rest.starts_with("<?")) {
      at = end_of(text, at, "?>");
    } else if (rest.starts_with("<![CDATA[")) {
      at = end_of(text, at, "]]>");
    } else if (rest.starts_with("<!")) {
      at = end_of_tag(text, at);
      const std::string_view declaration = text.substr(begin, at == std::string_view::npos ? at : at - begin);
      if (declaration.find("<!ENTITY") != std::string_view::npos ||
          declaration.find('[') != std::string_view::npos)
        return Error{"line " + std::to_string(line_of(text, begin)) +
                     ": it defines entities, which descriptions do without: write out what they stand for"};
    } else if (rest.starts_with("</")) {
      --depth;
      at = end_of_tag(text, at);
    } else {
      at = end_of_tag(text, at);
      const bool whole = at != std::string_view::npos;
      const std::string_view tag = text.substr(begin + 1, whole ? at - begin - 2 : 0);
      if (root.empty()) root = tag.substr(0, tag.find_first_of(" \t\r\n/"));
      if (!tag.ends_with('/') && ++depth > kMostDepth) {
        return Error{"line " + std::to_string(line_of(text, begin)) + ": more than " +
                     std::to_string(kMostDepth) + " elements inside each other"};
      }
    }
    if (at == std::string_view::npos) {
      return Error{"line " + std::to_string(line_of(text, begin)) + ": what begins here with '<' has no end"};
    }
  }
  return root;
}

Result<DescriptionKind> kind_of(const std::filesystem::path& file, std::string_view text) {
  const std::string name = scene::quote(file.string());
  if (text.starts_with("glTF")) return Error{name + " is glTF already: give it to fire3dv as it is"};
  if (text.find('\0') != std::string_view::npos)
    return Error{name + " is no text: a description is YAML or XML"};
  const Result<std::string> root = xml_root(text);
  if (!root) return Error{name + ": " + root.error().message};
  if (*root == "mujoco" || *root == "mujocoinclude") return DescriptionKind::mjcf;
  if (*root == "robot") {
    if (text.find("<xacro:") != std::string_view::npos) {
      return Error{name + " is a xacro file, which has to be made into URDF first: xacro " +
                   file.filename().string() + " > " + file.stem().stem().string() + ".urdf"};
    }
    return DescriptionKind::urdf;
  }
  if (*root == "sdf") return Error{name + " is SDF, which is not read: export it as URDF, or as glTF"};
  if (!root->empty()) {
    return Error{name + " is XML of the kind " + scene::quote(*root) +
                 ": <robot> (URDF) and <mujoco> (MJCF) are read"};
  }
  for (const std::string_view key : {"multibody configs", "world config", "bodies", "lights", "cameras",
                                     "environment", "soft bodies", "ghost objects", "joints", "volumes"})
    if (has_key(text, key)) return DescriptionKind::adf;
  return Error{name +
               " is no description that is known: an AMBF file (YAML with bodies, multibody configs, or "
               "a world's lights and cameras), URDF or MJCF"};
}

}  // namespace fire3dv::convert

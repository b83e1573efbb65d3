#include "convert/sdf/files/sdf_include_text.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace fire3dv::convert {
namespace {

struct Tag {
  size_t begin = 0, end = 0;  // of "<name ...>"
  std::string_view name;
  bool closes = false;    // </name>
  bool is_empty = false;  // <name/>
};

// Next element tag at or after `at`; comments, CDATA and declarations are skipped.
std::optional<Tag> next_tag(std::string_view text, size_t at) {
  for (at = text.find('<', at); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    const char* closing = rest.starts_with("<!--")                           ? "-->"
                          : rest.starts_with("<![CDATA[")                    ? "]]>"
                          : rest.starts_with("<!") || rest.starts_with("<?") ? ">"
                                                                             : nullptr;
    if (closing) {
      at = text.find(closing, at + 2);
      if (at == std::string_view::npos) return std::nullopt;
      continue;
    }
    Tag tag;
    tag.begin = at;
    tag.closes = rest.starts_with("</");
    const size_t name = at + (tag.closes ? 2 : 1);
    const size_t name_end = std::min(text.find_first_of(" \t\r\n/>", name), text.size());
    tag.name = text.substr(name, name_end - name);
    char quote = 0;
    for (at = name_end; at < text.size() && (quote || text[at] != '>'); ++at) {
      if (quote ? text[at] == quote : text[at] == '"' || text[at] == '\'') quote = quote ? '\0' : text[at];
    }
    if (at >= text.size()) return std::nullopt;
    tag.is_empty = text[at - 1] == '/' && !tag.closes;
    tag.end = at + 1;
    return tag;
  }
  return std::nullopt;
}

// Position behind the element that begins with `tag`.
size_t end_of_element(std::string_view text, const Tag& tag) {
  if (tag.is_empty) return tag.end;
  size_t depth = 1;
  for (std::optional<Tag> next = next_tag(text, tag.end); next; next = next_tag(text, next->end)) {
    if (next->closes)
      --depth;
    else if (!next->is_empty)
      ++depth;
    if (depth == 0) return next->end;
  }
  return text.size();
}

std::string only_lines(std::string_view text) {
  return std::string(static_cast<size_t>(std::count(text.begin(), text.end(), '\n')), '\n');
}

}  // namespace

Result<std::string> with_include_uris(const std::string& text,
                                      const std::vector<std::optional<std::string>>& replacements) {
  std::string made;
  size_t kept = 0, count = 0;  // text before `kept` is in `made`
  const auto replace = [&](size_t begin, size_t end, const std::string& by) {
    made.append(text, kept, begin - kept);
    made += by + only_lines(std::string_view(text).substr(begin, end - begin));
    kept = end;
  };
  for (std::optional<Tag> tag = next_tag(text, 0); tag; tag = next_tag(text, tag->end)) {
    if (tag->closes || tag->name != "include") continue;
    if (count >= replacements.size()) return Error{"an <include> cannot be found again: write it plainly"};
    const std::optional<std::string>& by = replacements[count++];
    if (!by || tag->begin < kept) continue;
    const size_t end = end_of_element(text, *tag);
    if (by->empty()) {
      replace(tag->begin, end, "");
      continue;
    }
    // The first <uri> that is a child.
    std::optional<Tag> child = next_tag(text, tag->end);
    while (child && child->begin < end && !(child->name == "uri" && !child->closes))
      child = next_tag(text, child->closes ? child->end : end_of_element(text, *child));
    if (!child || child->begin >= end) return Error{"a <uri> cannot be found again: write it plainly"};
    replace(child->begin, end_of_element(text, *child), "<uri>" + *by + "</uri>");
  }
  if (count != replacements.size()) return Error{"an <include> cannot be found again: write it plainly"};
  made.append(text, kept);
  return made;
}

std::string with_sdf_version(std::string text, const std::string& version) {
  const std::optional<Tag> root = next_tag(text, 0);
  if (!root) return text;
  for (size_t at = text.find("version", root->begin); at < root->end; at = text.find("version", at + 1)) {
    const size_t equals = text.find_first_not_of(" \t\r\n", at + 7);
    if (equals >= root->end || text[equals] != '=' ||
        std::string_view(" \t\r\n").find(text[at - 1]) == std::string_view::npos)
      continue;
    const size_t open = text.find_first_of("\"'", equals);
    const size_t close = open < root->end ? text.find(text[open], open + 1) : std::string::npos;
    if (close >= root->end) continue;
    return text.replace(open + 1, close - open - 1, version);
  }
  return text;
}

}  // namespace fire3dv::convert

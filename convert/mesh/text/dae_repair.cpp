#include "convert/mesh/text/dae_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "base/numbers.h"
#include "base/text.h"
#include "base/words.h"
#include "convert/mesh/geometry/polygon_holes.h"
#include "convert/mesh/text/mesh_text.h"

namespace fire3dv::convert {
namespace {

std::optional<double> finite(std::string_view token) {
  if (token.starts_with('+')) token.remove_prefix(1);
  const std::optional<double> value = parse_number<double>(token);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// Bytes of an attribute's value in a tag.
struct Range {
  size_t begin = 0, end = 0;
};

std::optional<Range> find_attribute(std::string_view tag, std::string_view name) {
  for (size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    if (at == 0 || kBlanks.find(tag[at - 1]) == std::string_view::npos) continue;
    size_t next = tag.find_first_not_of(kBlanks, at + name.size());
    if (next == std::string_view::npos || tag[next] != '=') continue;
    next = tag.find_first_not_of(kBlanks, next + 1);
    if (next == std::string_view::npos || (tag[next] != '"' && tag[next] != '\'')) continue;
    const size_t end = tag.find(tag[next], next + 1);
    if (end != std::string_view::npos) return Range{next + 1, end};
  }
  return std::nullopt;
}

std::string_view attribute_value(std::string_view tag, std::string_view name) {
  const std::optional<Range> range = find_attribute(tag, name);
  return range ? tag.substr(range->begin, range->end - range->begin) : std::string_view();
}

std::optional<uint64_t> whole_number(std::string_view text) {
  return parse_number<uint64_t>(trimmed(text));
}

// Elements of a node that place it, with the value of no movement.
std::optional<std::string_view> identity_of(std::string_view element) {
  static constexpr std::pair<std::string_view, std::string_view> kIdentities[] = {
      {"matrix", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"},
      {"translate", "0 0 0"},
      {"rotate", "0 0 1 0"},
      {"scale", "1 1 1"}};
  for (const auto& [name, identity] : kIdentities)
    if (name == element) return identity;
  return std::nullopt;
}

bool is_primitive(std::string_view element) {
  static constexpr std::string_view kNames[] = {"triangles",  "polylist", "polygons",  "lines",
                                                "linestrips", "trifans",  "tristrips", "vertices"};
  return std::find(std::begin(kNames), std::end(kNames), element) != std::end(kNames);
}

class DaeRepair {
 public:
  explicit DaeRepair(std::string_view text) : in_(text) { out_.reserve(text.size() + 64); }

  RepairedDae repair() {
    while (at_ < in_.size()) {
      const size_t tag = std::min(in_.find('<', at_), in_.size());
      add_text(in_.substr(at_, tag - at_));
      at_ = tag;
      if (at_ < in_.size() && !add_markup()) break;
    }
    out_ += in_.substr(at_);
    RepairedDae result;
    result.text = std::move(out_);
    for (const auto& [what, seen] : problems_) {
      result.warnings.push_back(seen.first +
                                (seen.second > 1 ? " and " + std::to_string(seen.second - 1) + " more" : "") +
                                ": " + what);
    }
    return result;
  }

 private:
  struct Element {
    std::string_view name, tag;
  };
  // Count of the open array or primitive, and what there is of it.
  struct Count {
    std::optional<Range> place;  // in the output
    size_t tag_end = 0;          // in the output, where a missing attribute is added
    std::optional<uint64_t> stated;
    std::string label;
    uint64_t stride = 1, indices = 0;
    std::optional<uint64_t> polygons;
    std::string_view vertices;  // source of the positions' numbers
    uint64_t vertex_offset = 0;
  };
  // Positions in the file, by the identifier of their <source>.
  struct PositionSource {
    std::string_view numbers;
    uint64_t stride = 3;
    std::optional<std::vector<glm::dvec3>> positions;  // once they are read
  };

  void report(const std::string& object, const std::string& what) {
    auto& [first, count] = problems_[what];
    if (count++ == 0) first = object;
  }

  std::string_view top() const { return open_.empty() ? std::string_view() : open_.back().name; }
  std::string_view parent() const {
    return open_.size() < 2 ? std::string_view() : open_[open_.size() - 2].name;
  }

  // The innermost element of this kind that has a name; without a kind, of any.
  std::string label(std::string_view wanted = {}) const {
    for (size_t i = open_.size(); i-- > 0;) {
      if (!wanted.empty() && open_[i].name != wanted) continue;
      for (const char* name : {"name", "id", "sid"}) {
        const std::string_view value = attribute_value(open_[i].tag, name);
        if (!value.empty()) return std::string(open_[i].name) + " " + quote(value);
      }
    }
    return "<" + std::string(top()) + ">";
  }

  // Copies up to the end of a comment or other markup that is no element. Returns false for broken markup.
  bool add_until(std::string_view end) {
    const size_t found = in_.find(end, at_);
    if (found == std::string_view::npos) return false;
    out_ += in_.substr(at_, found + end.size() - at_);
    at_ = found + end.size();
    return true;
  }

  bool add_markup() {
    const std::string_view rest = in_.substr(at_);
    if (rest.starts_with("<!--")) return skip_to("-->", 0);  // assimp takes some for elements
    if (rest.starts_with("<![CDATA[")) return add_until("]]>");
    if (rest.starts_with("<?")) return add_until("?>");
    if (rest.starts_with("<!")) return add_until(rest.find('[') < rest.find('>') ? "]>" : ">");  // a DOCTYPE
    if (rest.starts_with("</")) return add_end_tag();
    return add_tag();
  }

  bool add_end_tag() {
    const size_t end = in_.find('>', at_);
    if (end == std::string_view::npos) return false;
    const std::string_view name = trimmed(in_.substr(at_ + 2, end - at_ - 2));
    if (open_.empty() || open_.back().name != name) return false;
    if (last_is_start_) add_content({});  // an element without any text
    last_is_start_ = false;
    // assimp refuses images without a file.
    if (name == "image" && !image_has_file_) out_ += "<init_from>" + image_name() + "</init_from>";
    if (count_ && (name == "triangles" || name == "polylist")) fix_primitive_count(name);
    if (name == "float_array" || is_primitive(name)) count_.reset();
    out_ += in_.substr(at_, end + 1 - at_);
    at_ = end + 1;
    open_.pop_back();
    return true;
  }

  bool add_tag() {
    size_t end = at_ + 1;
    char quoted = 0;
    for (; end < in_.size() && (quoted || in_[end] != '>'); ++end) {
      if (quoted && in_[end] == quoted)
        quoted = 0;
      else if (!quoted && (in_[end] == '"' || in_[end] == '\''))
        quoted = in_[end];
    }
    if (end >= in_.size()) return false;
    const std::string_view tag = in_.substr(at_, end + 1 - at_);
    const size_t name_end = tag.find_first_of(" \t\r\n/>", 1);
    const std::string_view name = tag.substr(1, name_end - 1);
    const bool is_empty = tag[tag.size() - 2] == '/';
    if (name == "extra" && is_primitive(top()))
      return skip_to(is_empty ? ">" : "</extra>", is_empty ? end - at_ : end + 1 - at_);
    if (name == "ph" && count_ && !is_empty) {
      at_ = end + 1;
      return add_polygon_with_holes();
    }
    at_ = end + 1;
    last_is_start_ = !is_empty;
    const size_t begin = out_.size();
    if (name == "unit") {
      add_unit(tag);
    } else if (is_empty && name == "color") {
      out_ += "<color>";
      open_.push_back({name, tag});
      add_content({});
      open_.pop_back();
      out_ += "</color>";
    } else {
      out_ += tag;
    }
    if (name == "input" && count_) take_input(tag);
    if (name == "accessor")
      sources_[source_id()].stride = whole_number(attribute_value(tag, "stride")).value_or(1);
    if (is_empty) return true;
    open_.push_back({name, tag});
    if (name == "image") image_has_file_ = false;
    if (name == "init_from" || name == "data") image_has_file_ = true;
    if (name == "float_array" || is_primitive(name)) open_count(tag, begin);
    return true;
  }

  // The identifier of the innermost image, which stands for the missing name of its file.
  std::string image_name() const {
    for (size_t i = open_.size(); i-- > 0;)
      if (open_[i].name == "image") return std::string(attribute_value(open_[i].tag, "id")) + " (unnamed)";
    return {};
  }

  // Leaves out what assimp refuses, such as elements of other programs inside of primitives.
  bool skip_to(std::string_view end, size_t from) {
    const size_t found = in_.find(end, at_ + from);
    if (found == std::string_view::npos) return false;
    at_ = found + end.size();
    return true;
  }

  void open_count(std::string_view tag, size_t begin) {
    count_.emplace();
    count_->label = label();
    count_->tag_end = out_.size() - 1;
    if (const std::optional<Range> range = find_attribute(tag, "count")) {
      count_->place = Range{begin + range->begin, begin + range->end};
      count_->stated = whole_number(attribute_value(tag, "count"));
    }
  }

  void take_input(std::string_view tag) {
    const uint64_t offset =
        std::min<uint64_t>(whole_number(attribute_value(tag, "offset")).value_or(0), 1000);
    count_->stride = std::max(count_->stride, offset + 1);
    const std::string_view semantic = attribute_value(tag, "semantic");
    std::string_view source = attribute_value(tag, "source");
    if (source.starts_with('#')) source.remove_prefix(1);
    if (semantic == "VERTEX") {
      count_->vertices = source;
      count_->vertex_offset = offset;
    } else if (semantic == "POSITION" && top() == "vertices") {
      position_sources_[attribute_value(open_.back().tag, "id")] = source;
    }
  }

  // The identifier of the innermost <source>.
  std::string_view source_id() const {
    for (size_t i = open_.size(); i-- > 0;)
      if (open_[i].name == "source") return attribute_value(open_[i].tag, "id");
    return {};
  }

  // Positions that the open primitive names; null if they are not found.
  const std::vector<glm::dvec3>* positions() {
    const auto named = position_sources_.find(count_->vertices);
    const auto found = named == position_sources_.end() ? sources_.end() : sources_.find(named->second);
    if (found == sources_.end() || found->second.stride < 3) return nullptr;
    PositionSource& source = found->second;
    if (!source.positions) {
      source.positions.emplace();
      glm::dvec3 position(0);
      uint64_t at = 0;
      std::string_view rest = source.numbers;
      for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
        if (at < 3) position[static_cast<int>(at)] = number_of(word).value_or(NAN);
        if (at == 2) source.positions->push_back(position);
        at = at + 1 == source.stride ? 0 : at + 1;
      }
    }
    return &*source.positions;
  }

  // A <ph>, whose holes assimp does not know, as one polygon with doubled edges to its holes.
  bool add_polygon_with_holes() {
    const size_t end = in_.find("</ph>", at_);
    if (end == std::string_view::npos) return false;
    const std::string_view content = in_.substr(at_, end - at_);
    at_ = end + 5;
    std::vector<std::string_view> words;  // numbers of all rings
    std::vector<size_t> ring_ends;        // in corners; the outline's is the first
    for (const std::string_view element : {"p", "h"}) {
      const std::string begin_tag = "<" + std::string(element), end_tag = "</" + std::string(element);
      for (size_t at = content.find(begin_tag); at != std::string_view::npos;
           at = content.find(begin_tag, at)) {
        const size_t text = std::min(content.find('>', at), content.size() - 1) + 1;
        at = std::min(content.find(end_tag, text), content.size());
        std::string_view rest = content.substr(text, at - text);
        for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest))
          words.push_back(word);
        words.resize(words.size() - words.size() % count_->stride);
        ring_ends.push_back(words.size() / count_->stride);
        if (element == "p") break;
      }
    }
    if (ring_ends.empty()) return true;
    std::vector<uint32_t> corners = joined_corners(words, ring_ends);
    if (corners.empty()) {
      report("<polygons>", "holes that no edge joins to their outline are closed");
      corners.resize(ring_ends[0]);
      std::iota(corners.begin(), corners.end(), uint32_t{0});
    }
    count_->indices += corners.size() * count_->stride;
    out_ += "<p>";
    for (const uint32_t corner : corners) {
      for (uint64_t i = 0; i < count_->stride; ++i) {
        out_ += words[corner * count_->stride + i];
        out_ += ' ';
      }
    }
    out_ += "</p>";
    return true;
  }

  std::vector<uint32_t> joined_corners(const std::vector<std::string_view>& words,
                                       const std::vector<size_t>& ring_ends) {
    const std::vector<glm::dvec3>* const known = positions();
    if (!known) return {};
    std::vector<HoleJoiner::Ring> rings;
    size_t corner = 0;
    for (const size_t ring_end : ring_ends) {
      HoleJoiner::Ring& ring = rings.emplace_back();
      for (; corner < ring_end; ++corner) {
        const auto index = whole_number(words[corner * count_->stride + count_->vertex_offset]);
        if (!index || *index >= known->size()) return {};
        ring.push_back((*known)[*index]);
      }
    }
    return holes_.join(rings);
  }

  // Writes the count of the open element. The contents follow it, so that the output is moved.
  void set_count(uint64_t count) {
    const std::string text = std::to_string(count);
    if (count_->place)
      out_.replace(count_->place->begin, count_->place->end - count_->place->begin, text);
    else
      out_.insert(count_->tag_end, " count=\"" + text + "\"");
  }

  void fix_primitive_count(std::string_view name) {
    std::optional<uint64_t> right = count_->polygons;
    if (name == "triangles" && count_->indices % (3 * count_->stride) == 0)
      right = count_->indices / (3 * count_->stride);
    if (!right || right == count_->stated) return;
    set_count(*right);
    report("<" + std::string(name) + ">", "its count is not that of its contents");
  }

  // A scale of 0 or none would make the scene invisible.
  void add_unit(std::string_view tag) {
    const std::optional<Range> range = find_attribute(tag, "meter");
    if (!range) {
      out_ += tag;
      return;
    }
    std::string_view value = trimmed(tag.substr(range->begin, range->end - range->begin));
    const std::optional<double> metres = finite(value);
    if (value.find(',') == std::string_view::npos && (!metres || *metres <= 0)) {
      report("<unit>", "its meter is no positive number: 1 is taken");
      value = "1";
    }
    out_ += tag.substr(0, range->begin);
    out_ += value;
    out_ += tag.substr(range->end);
  }

  void add_text(std::string_view text) {
    const bool is_content = last_is_start_ && in_.substr(at_ + text.size()).starts_with("</");
    const std::string_view content = trimmed(text);
    if (!is_content) out_ += text;
    if (is_content && !content.empty()) add_content(content);  // empty: completed at the end tag
    if (!content.empty()) last_is_start_ = false;
  }

  // Text of the innermost element.
  void add_content(std::string_view text) {
    const std::string_view element = top();
    if (element == "color") return add_color(text);
    if (element == "float_array") return add_array(text);
    if (element == "init_from" && parent() == "image" && text.empty()) {
      out_ += image_name();
      return;
    }
    if (count_ && element == "p") count_->indices += count_words(text);
    if (count_ && element == "vcount") count_->polygons = count_words(text);
    if (const auto identity = identity_of(element); identity && parent() == "node")
      return add_transform(text, *identity);
    out_ += text;
  }

  void add_color(std::string_view text) {
    std::array<std::string_view, 4> numbers = {"0", "0", "0", "1"};
    size_t count = 0;
    for (std::string_view token = next_word(text); !token.empty() && count < 4; token = next_word(text)) {
      const bool is_sound = finite(token) || token.find(',') != std::string_view::npos;  // assimp reads 0,5
      if (!is_sound) report(label("effect"), "a colour is not made of numbers: 0 is taken for them");
      if (is_sound) numbers[count] = token;
      ++count;
    }
    if (count == 0 && parent() == "diffuse") numbers = {"0.8", "0.8", "0.8", "1"};
    for (size_t i = 0; i < 4; ++i) {
      if (i > 0) out_ += ' ';
      out_ += numbers[i];
    }
  }

  void add_transform(std::string_view text, std::string_view identity) {
    size_t count = 0;
    bool is_sound = true;
    for (std::string_view rest = text, token = next_word(rest); !token.empty(); token = next_word(rest)) {
      ++count;
      is_sound = is_sound && (finite(token) || token.find(',') != std::string_view::npos);
    }
    if (is_sound && count >= count_words(identity)) {
      out_ += text;
      return;
    }
    report(label("node"), "its <" + std::string(top()) + "> is not made of finite numbers and left out");
    out_ += identity;
  }

  void add_array(std::string_view text) {
    constexpr std::string_view kUsual = "0123456789+-.eE \t\r\n";
    const size_t begin = out_.size();
    uint64_t count = 0;
    if (top() == "float_array") sources_[source_id()].numbers = text;
    if (text.find_first_not_of(kUsual) == std::string_view::npos) {
      out_ += text;
      count = count_words(text);
    } else {
      for (std::string_view token = next_word(text); !token.empty(); token = next_word(text)) {
        if (count++ > 0) out_ += ' ';
        while (token.ends_with(',')) token.remove_suffix(1);
        // NaN and infinity as programs write them, such as -nan(ind) and 1.#QNAN.
        const std::string lower = token.find_first_not_of(kUsual) == std::string_view::npos
                                      ? std::string()
                                      : lower_case(std::string(token.substr(0, 20)));
        const bool is_none = lower.find("nan") != std::string::npos ||
                             lower.find("inf") != std::string::npos || lower.find('#') != std::string::npos;
        out_ += is_none ? std::string_view("nan") : token;
      }
    }
    if (!count_ || count_->stated == count) return;
    // Numbers that are missing: what uses them is left out, as for NaN.
    constexpr uint64_t kMaxMissing = 1'000'000;
    const uint64_t stated = count_->stated.value_or(0);
    report(count_->label, "its count is not that of its contents");
    if (stated > count + kMaxMissing) return;
    for (uint64_t i = count; i < stated; ++i) out_ += out_.size() == begin ? "nan" : " nan";
    if (stated < count) set_count(count);
  }

  std::string_view in_;
  std::string out_;
  size_t at_ = 0;
  bool image_has_file_ = true;
  bool last_is_start_ = false;  // the last markup opened the innermost element
  std::vector<Element> open_;
  std::optional<Count> count_;
  std::map<std::string_view, PositionSource> sources_;
  std::map<std::string_view, std::string_view> position_sources_;  // of <vertices>, by its identifier
  HoleJoiner holes_;
  std::map<std::string, std::pair<std::string, size_t>>
      problems_;  // first object and count, by what is wrong
};

}  // namespace

RepairedDae repair_dae(std::string_view text) {
  const std::optional<std::string> decoded = utf8_of_utf16(text);
  return DaeRepair(decoded ? *decoded : text).repair();
}

}  // namespace fire3dv::convert

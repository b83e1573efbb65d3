#include "convert/mesh/text/obj_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "base/plural.h"
#include "base/text.h"
#include "base/words.h"
#include "convert/mesh/text/mesh_text.h"

namespace fire3dv::convert {
namespace {

// Kinds of elements that faces name.
enum Kind : size_t { kVertex, kUv, kNormal, kKinds };
constexpr std::string_view kStatements[kKinds] = {"v", "vt", "vn"};
constexpr const char* kNames[kKinds] = {"vertex", "texture coordinate", "normal"};

// Takes a line without its end, and the lines that a backslash at the end joins to it.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    joined_.clear();
    number_ += physical_;
    physical_ = 0;
    while (true) {
      const size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
      line = rest_.substr(0, end);
      const bool is_pair = rest_.substr(end).starts_with("\r\n");
      rest_.remove_prefix(std::min(end + (is_pair ? 2 : 1), rest_.size()));
      ++physical_;
      const size_t last = line.find_last_not_of(" \t");
      const bool goes_on = last != std::string_view::npos && line[last] == '\\' && !line.starts_with('#');
      if (goes_on) line = line.substr(0, last);
      if (!goes_on && joined_.empty()) return true;
      joined_ += line;
      joined_ += ' ';
      if (goes_on && !rest_.empty()) continue;
      line = joined_;
      return true;
    }
  }
  // Of the first physical line, from 1.
  size_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::string joined_;
  size_t number_ = 1, physical_ = 0;
};

// assimp compares the name of each object with all before it, so that more of them become groups, which are
// nodes as well.
constexpr size_t kMaxObjects = 4096;

class ObjChecker {
 public:
  Result<ObjText> check(std::string_view file) {
    // Faces may precede the elements that they name.
    Lines counting(file);
    std::string_view line;
    while (counting.next(line)) {
      std::string_view rest = line;
      const std::string_view word = next_word(rest);
      for (size_t kind = 0; kind < kKinds; ++kind) totals_[kind] += word == kStatements[kind] ? 1 : 0;
      objects_ += word == "o" ? 1 : 0;
    }
    Result<void> read = read_lines(file);
    // Faces that precede their damaged vertex need another pass, which knows those vertices.
    if (read && has_early_faces_) {
      begin_again();
      read = read_lines(file);
    }
    if (!read) return Error{"line " + std::to_string(line_) + ": " + read.error().message};
    if (totals_[kVertex] == 0 && !has_faces_)
      return Error{"it is damaged, or not what its name says (there is neither a vertex nor a face)"};
    if (faces_ == 0 && left_out_.count > 0)
      return Error{"line " + std::to_string(damaged_.line) + ": the vertex is damaged: " + damaged_.reason};
    add_warnings();
    // assimp refuses shorter files.
    result_.text += "# end of the file\n";
    return std::move(result_);
  }

 private:
  struct Fault {
    size_t line = 0, count = 0;
    std::string reason;
    void note(size_t at_line, std::string why) {
      if (count++ > 0) return;
      line = at_line;
      reason = std::move(why);
    }
  };

  Result<void> read_lines(std::string_view file) {
    result_.text.reserve(file.size() + file.size() / 4 + 64);
    Lines lines(file);
    std::string_view line;
    while (lines.next(line)) {
      line_ = lines.number();
      std::string_view rest = line;
      const std::string_view word = next_word(rest);
      Result<void> done;
      if (word == "v")
        done = add_vertex(rest);
      else if (word == "vt")
        add_numbers(kUv, rest, 1, 3);
      else if (word == "vn")
        add_numbers(kNormal, rest, 3, 3);
      else if (word == "f" || word == "fo")
        done = add_face(rest);
      else if (word == "o" && objects_ > kMaxObjects)
        add_line("g " + std::string(rest));
      else if (word != "l" && word != "p" && !word.empty() && word[0] != '#')
        add_line(line);
      if (!done) return done;
    }
    return {};
  }

  // Keeps the numbers of damaged vertices.
  void begin_again() {
    result_ = {};
    std::fill(std::begin(counts_), std::end(counts_), 0);
    faces_ = 0;
    for (Fault* fault : {&damaged_, &left_out_, &flat_}) *fault = {};
    for (Fault* faults : {missing_, bad_numbers_})
      for (size_t kind = 0; kind < kKinds; ++kind) faults[kind] = {};
  }

  void add_line(std::string_view line) {
    line = line.substr(0, line.find_last_not_of(" \t\\") + 1);  // a backslash would join the next line
    for (const char c : line) result_.text += c == '\0' ? '?' : c;
    result_.text += '\n';
  }

  // Numbers in the one form that assimp reads, or 0 for others.
  void append_number(std::string_view word, double value) {
    result_.text += ' ';
    const bool is_plain = !word.empty() && (word[0] == '-' || (word[0] >= '0' && word[0] <= '9')) &&
                          word.find_first_not_of("-0123456789.") == std::string_view::npos &&
                          word.find("-.") == std::string_view::npos && word.size() < 16;
    if (is_plain) {
      result_.text += word;
      return;
    }
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), static_cast<float>(value));
    result_.text.append(digits.data(), end.ptr);
  }

  // Position with an optional weight or colour.
  Result<void> add_vertex(std::string_view rest) {
    constexpr size_t kMaxNumbers = 8;
    std::array<std::string_view, kMaxNumbers> words;
    std::array<double, kMaxNumbers> values{};
    size_t count = 0;
    std::string fault;
    for (; count < kMaxNumbers; ++count) {
      const std::string_view word = next_word(rest);
      if (word.empty() || word[0] == '#') break;
      words[count] = word;
      const std::optional<double> value = number_of(word);
      if (value && std::isfinite(static_cast<float>(*value))) {
        values[count] = *value;
      } else if (has_decimal_comma(word)) {
        return Error{not_a_number(word)};
      } else if (count < 3) {
        fault = fault.empty() ? not_a_number(word) : fault;
      } else {  // a colour
        bad_numbers_[kVertex].note(line_, not_a_number(word));
        values[count] = 1;
        words[count] = "1";
      }
    }
    ++counts_[kVertex];
    if (count < 2 && fault.empty()) fault = "a vertex has fewer than three numbers";
    if (count == 2 && fault.empty()) {
      flat_.note(line_, {});
      words[count++] = "0";
    }
    if (!fault.empty()) {
      constexpr size_t kMaxBadVertices = 100'000;
      if (bad_vertices_.size() >= kMaxBadVertices && !bad_vertices_.contains(counts_[kVertex]))
        return Error{fault};
      bad_vertices_.insert(counts_[kVertex]);
      has_early_faces_ = has_early_faces_ || counts_[kVertex] <= last_named_;
      damaged_.note(line_, fault);
      result_.text += "v 0 0 0\n";
      return {};
    }
    // x y z, x y z w, x y z r g b, x y z r g b a. The weight w is that of curves alone.
    const size_t used = count >= 6 ? 6 : 3;
    result_.text += 'v';
    for (size_t i = 0; i < used; ++i) append_number(words[i], values[i]);
    result_.text += '\n';
    return {};
  }

  void add_numbers(Kind kind, std::string_view rest, size_t least, size_t most) {
    ++counts_[kind];
    result_.text += kStatements[kind];
    size_t count = 0;
    for (; count < most; ++count) {
      const std::string_view word = next_word(rest);
      if (word.empty() || word[0] == '#') break;
      const std::optional<double> value = number_of(word);
      if (value && std::isfinite(static_cast<float>(*value))) {
        append_number(word, *value);
      } else {
        bad_numbers_[kind].note(line_, not_a_number(word));
        result_.text += " 0";
      }
    }
    if (count < least) bad_numbers_[kind].note(line_, "a number is missing");
    const size_t whole = std::max<size_t>(least, 2);
    for (; count < whole; ++count) result_.text += " 0";
    result_.text += '\n';
  }

  // Number of an element from 1. Empty: none. 0: out of range.
  Result<uint64_t> index(std::string_view word, Kind kind) {
    int64_t number = 0;
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error == std::errc::invalid_argument || end != word.data() + word.size())
      return Error{"a face names a " + std::string(kNames[kind]) + " by " + quote(word) + "; write a number"};
    if (error != std::errc()) return uint64_t{0};
    if (number < 0) number = static_cast<int64_t>(counts_[kind]) + number + 1;
    return number > 0 && static_cast<uint64_t>(number) <= totals_[kind] ? static_cast<uint64_t>(number) : 0;
  }

  Result<void> add_face(std::string_view rest) {
    corners_.clear();
    size_t with[kKinds] = {};
    bool is_damaged = false;
    for (std::string_view word = next_word(rest); !word.empty() && word[0] != '#'; word = next_word(rest)) {
      std::array<uint64_t, kKinds> corner{};
      std::string_view left = word;
      for (const Kind kind : {kVertex, kUv, kNormal}) {
        const size_t end = std::min(left.find('/'), left.size());
        const std::string_view part = left.substr(0, end);
        left.remove_prefix(std::min(end + 1, left.size()));
        if (part.empty() && kind != kVertex) continue;
        const Result<uint64_t> number = index(part, kind);
        if (!number) return number.error();
        if (*number == 0 && kind == kVertex)
          return Error{"a face names vertex " + std::string(part.substr(0, 20)) + ", but there are " +
                       std::to_string(totals_[kind]) + ", counted from 1"};
        if (*number == 0) missing_[kind].note(line_, {});
        corner[kind] = *number;
        with[kind] += *number != 0 ? 1 : 0;
      }
      is_damaged = is_damaged || bad_vertices_.contains(corner[kVertex]);
      last_named_ = std::max(last_named_, corner[kVertex]);
      corners_.push_back(corner);
    }
    has_faces_ = has_faces_ || !corners_.empty();
    if (corners_.size() < 3) return {};
    if (is_damaged) {
      left_out_.note(line_, {});
      return {};
    }
    ++faces_;
    // A face has texture coordinates, or normals, at all of its corners or at none.
    bool has[kKinds] = {};
    for (const Kind kind : {kUv, kNormal}) {
      has[kind] = with[kind] == corners_.size();
      if (!has[kind] && with[kind] > 0) missing_[kind].note(line_, {});
    }
    const size_t begin = result_.text.size();
    result_.text += 'f';
    for (const std::array<uint64_t, kKinds>& corner : corners_) {
      result_.text += ' ' + std::to_string(corner[kVertex]);
      if (has[kUv] || has[kNormal]) result_.text += '/';
      if (has[kUv]) result_.text += std::to_string(corner[kUv]);
      if (has[kNormal]) result_.text += '/' + std::to_string(corner[kNormal]);
    }
    result_.text += '\n';
    constexpr size_t kMaxLine = size_t{1} << 23;  // half of assimp's buffer for a line
    if (result_.text.size() - begin > kMaxLine)
      return Error{"a face has " + std::to_string(corners_.size()) + " corners, which are too many"};
    return {};
  }

  void add_warnings() {
    const auto add = [&](const Fault& fault, const std::string& what) {
      if (fault.count == 0) return;
      result_.warnings.push_back(what + " (" + counted(fault.count, "time") + ", first in line " +
                                 std::to_string(fault.line) +
                                 (fault.reason.empty() ? "" : ": " + fault.reason) + ")");
    };
    if (left_out_.count > 0)
      add(damaged_, counted(left_out_.count, "face") + " with damaged vertices: left out");
    add(flat_, "vertices have two numbers: the third is 0");
    add(bad_numbers_[kVertex], "colours of vertices are damaged: 1 is used");
    for (const Kind kind : {kUv, kNormal}) {
      add(missing_[kind], "faces name " + std::string(kNames[kind]) +
                              "s that are missing: such faces are drawn without them");
      add(bad_numbers_[kind], "a " + std::string(kNames[kind]) + " is damaged: 0 is used");
    }
  }

  ObjText result_;
  size_t line_ = 0;
  uint64_t counts_[kKinds] = {}, totals_[kKinds] = {};
  size_t objects_ = 0;  // in the file
  bool has_faces_ = false;
  std::vector<std::array<uint64_t, kKinds>> corners_;
  uint64_t faces_ = 0;
  std::unordered_set<uint64_t> bad_vertices_;  // from 1
  uint64_t last_named_ = 0;                    // largest number of a vertex in the faces so far
  bool has_early_faces_ = false;               // a face may name a damaged vertex that follows it
  Fault damaged_, left_out_, flat_, missing_[kKinds], bad_numbers_[kKinds];
};

}  // namespace

Result<ObjText> checked_obj(std::string_view file) {
  const std::optional<std::string> decoded = utf8_of_utf16(file);
  return ObjChecker().check(decoded ? *decoded : without_mark(file));
}

}  // namespace fire3dv::convert

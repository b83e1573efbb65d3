#include "tools/convert/mesh/obj_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>

namespace fire3dv::convert {
namespace {

enum Kind : size_t { corners, texture_places, normals };
constexpr const char* kNames[] = {"corner", "texture coordinate", "normal"};

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

// Counts of vertex data, and the range of indices used.
class Faces {
 public:
  // line: without its line end.
  void take(std::string_view line) {
    line = line.substr(0, line.find('\0'));
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.size() < 2) return;
    if (line[0] == 'v' && is_blank(line[1])) ++count_[corners];
    if (line.size() > 2 && line[0] == 'v' && is_blank(line[2])) {
      if (line[1] == 't') ++count_[texture_places];
      if (line[1] == 'n') ++count_[normals];
    }
    if ((line[0] == 'f' || line[0] == 'l' || line[0] == 'p') && is_blank(line[1])) {
      has_faces_ = has_faces_ || line[0] == 'f';
      rest_ = line.substr(2);
      for (skip_blanks(); !rest_.empty(); skip_blanks()) take_corner(line[0] == 'f');
    }
  }

  Result<void> check() const {
    for (const Kind kind : {corners, texture_places, normals}) {
      if (lowest_[kind] >= 0 && highest_[kind] < count_[kind]) continue;
      const int64_t named = lowest_[kind] < 0 ? lowest_[kind] : highest_[kind] + 1;
      return Error{"names " + std::string(kNames[kind]) + " " + std::to_string(named) + " of " +
                   std::to_string(count_[kind]) + "; export the mesh again"};
    }
    for (const Kind kind : {texture_places, normals}) {
      if (lacks_[kind] && count_[kind] > 0)
        return Error{"has a " + std::string(kNames[kind]) +
                     " for some corners of faces, and none for others; " +
                     "export the mesh with all or without any"};
    }
    return has_faces_ ? Result<void>() : check_points();
  }

 private:
  // Without faces, the parser takes all vertices in order, with one texture coordinate and normal each.
  Result<void> check_points() const {
    constexpr int64_t kLeastCorners = 4;  // minimum of a convex hull
    if (count_[corners] < kLeastCorners)
      return Error{"has no faces and only " + std::to_string(count_[corners]) +
                   " corners; export the mesh with its faces"};
    for (const Kind kind : {texture_places, normals}) {
      if (count_[kind] != 0 && count_[kind] != count_[corners])
        return Error{"has no faces, " + std::to_string(count_[corners]) + " corners, and " +
                     std::to_string(count_[kind]) + " of the kind " + kNames[kind] +
                     "; export the mesh with its faces"};
    }
    return {};
  }

  void skip_blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }

  // Parses "1", "1/2", "1/2/3" or "1//3".
  void take_corner(bool of_face) {
    std::array<bool, 3> has{};
    has[corners] = take_number(corners);
    if (take_slash()) {
      const bool none = take_slash();
      has[texture_places] = !none && take_number(texture_places);
      has[normals] = (none || take_slash()) && take_number(normals);
    }
    for (const Kind kind : {texture_places, normals}) lacks_[kind] = lacks_[kind] || (of_face && !has[kind]);
  }

  bool take_slash() {
    const bool is_slash = rest_.starts_with('/');
    if (is_slash) rest_.remove_prefix(1);
    return is_slash;
  }

  // Parses like atoi(), as the parser does, and skips the rest up to a blank or slash.
  bool take_number(Kind kind) {
    constexpr int64_t kMaxCount = int64_t{1} << 40;
    const size_t end = std::min(rest_.find_first_of("/ \t"), rest_.size());
    std::string_view digits = rest_.substr(0, end);
    digits.remove_prefix(std::min(digits.find_first_not_of("\v\f"), digits.size()));
    const bool below = digits.starts_with('-');
    if (below || digits.starts_with('+')) digits.remove_prefix(1);
    int64_t number = 0;
    for (const char c : digits) {
      if (c < '0' || c > '9') break;
      number = std::min(10 * number + (c - '0'), kMaxCount);
    }
    // Negative indices count from the last element; 0 is read as the first.
    const int64_t index = below ? count_[kind] - number : std::max<int64_t>(number - 1, 0);
    lowest_[kind] = std::min(lowest_[kind], index);
    highest_[kind] = std::max(highest_[kind], index);
    rest_.remove_prefix(end);
    return true;
  }

  std::string_view rest_;  // rest of the line
  std::array<int64_t, 3> count_{}, lowest_{}, highest_{-1, -1, -1};
  std::array<bool, 3> lacks_{};  // some face vertex lacks this kind
  bool has_faces_ = false;
};

// Splits "a\ b.mtl c.mtl" in both readings: "a\", "b.mtl", "c.mtl" and "a b.mtl", "c.mtl".
void add_names(std::string_view line, std::vector<std::string>& names) {
  for (const bool escapes : {false, true}) {
    std::string name;
    const auto end_name = [&] {
      if (!name.empty()) names.push_back(std::move(name));
      name.clear();
    };
    for (size_t i = 0; i < line.size(); ++i) {
      if (escapes && line[i] == '\\' && i + 1 < line.size())
        name += line[++i];
      else if (line[i] == ' ')
        end_name();
      else
        name += line[i];
    }
    end_name();
  }
}

}  // namespace

Result<void> check_obj_faces(std::string_view text) {
  Faces faces;
  while (!text.empty()) {
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    faces.take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return faces.check();
}

Result<std::vector<std::string>> obj_material_files(std::string_view text) {
  constexpr size_t kMaxNames = 1000;
  constexpr std::string_view kWord = "mtllib";
  std::vector<std::string> names;
  for (size_t at = text.find(kWord); at != text.npos; at = text.find(kWord, at + 1)) {
    size_t begin = at;
    while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
    if (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r')
      continue;  // not at the start of a
                 // line
    const std::string_view rest = text.substr(at + kWord.size());
    if (rest.empty() || (rest[0] != ' ' && rest[0] != '\t')) continue;
    add_names(rest.substr(1, rest.find_first_of("\r\n") - 1), names);
    if (names.size() > kMaxNames)
      return Error{"names more than " + std::to_string(kMaxNames) + " files of materials"};
  }
  return names;
}

std::vector<std::filesystem::path> obj_material_paths(const std::string& mesh, const std::string& name) {
  const size_t end = mesh.find_last_of("/\\");
  if (end == mesh.npos || end == 0) return {name};
  std::istringstream folders(mesh.substr(0, end) + "/");
  std::vector<std::filesystem::path> paths;
  for (std::string folder; std::getline(folders, folder, ':');) {
    const bool needs_slash = !folder.empty() && folder.back() != '/';
    paths.emplace_back(folder + (needs_slash ? "/" : "") + name);
  }
  return paths;
}

}  // namespace fire3dv::convert

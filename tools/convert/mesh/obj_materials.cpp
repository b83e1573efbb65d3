#include "tools/convert/mesh/obj_materials.h"

#include <sstream>

namespace fire3dv::convert {
namespace {

// Splits "a\ b.mtl c.mtl" in both readings: "a\", "b.mtl", "c.mtl" and "a b.mtl", "c.mtl".
void add_names(std::string_view line, std::vector<std::string>& names) {
  for (const bool escapes : {false, true}) {
    std::string name;
    const auto keep = [&] {
      if (!name.empty()) names.push_back(std::move(name));
      name.clear();
    };
    for (size_t i = 0; i < line.size(); ++i) {
      if (escapes && line[i] == '\\' && i + 1 < line.size())
        name += line[++i];
      else if (line[i] == ' ')
        keep();
      else
        name += line[i];
    }
    keep();
  }
}

}  // namespace

Result<std::vector<std::string>> obj_material_files(std::string_view text) {
  constexpr size_t kMostNames = 1000;
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
    if (names.size() > kMostNames)
      return Error{"names more than " + std::to_string(kMostNames) + " files of materials"};
  }
  return names;
}

std::vector<std::filesystem::path> obj_material_places(const std::string& mesh, const std::string& name) {
  const size_t end = mesh.find_last_of("/\\");
  if (end == mesh.npos || end == 0) return {name};
  std::istringstream folders(mesh.substr(0, end) + "/");
  std::vector<std::filesystem::path> places;
  for (std::string folder; std::getline(folders, folder, ':');) {
    const bool needs_slash = !folder.empty() && folder.back() != '/';
    places.emplace_back(folder + (needs_slash ? "/" : "") + name);
  }
  return places;
}

}  // namespace fire3dv::convert

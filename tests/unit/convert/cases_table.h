// Rows of cases/cases.txt. Its head explains the columns.
#pragma once

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::test {

struct CaseRow {
  std::string line, file, triangles;
  std::string corners[6];
  std::vector<std::pair<std::string, std::string>> properties;
  std::string warning;

  bool is_gltf() const { return file.ends_with(".gltf") || file.ends_with(".glb"); }
};

inline std::filesystem::path cases_folder() {
  return std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/unit/convert/cases";
}

inline std::vector<CaseRow> case_rows() {
  std::ifstream table(cases_folder() / "cases.txt");
  std::vector<CaseRow> rows;
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream columns(line);
    CaseRow& row = rows.emplace_back();
    row.line = line;
    columns >> row.file >> row.triangles;
    for (std::string& corner : row.corners) columns >> corner;
    std::getline(columns >> std::ws, row.warning);
    const std::regex property("^([a-z]+(@\\S+)?)=(\\S+)\\s+");
    for (std::smatch found; std::regex_search(row.warning, found, property);) {
      row.properties.emplace_back(found[1], found[3]);
      row.warning = std::string(found.suffix());
    }
  }
  return rows;
}

}  // namespace fire3dv::test

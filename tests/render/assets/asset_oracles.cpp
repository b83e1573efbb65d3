// Parser of the oracle table, and comparison of images with it.
#include "tests/render/assets/asset_oracles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace fire3dv::test {
namespace {

// Rounding differs by less, and materials differ by more. With few pixels a single edge pixel shifts the mean
// more.
int color_margin(int covered) {
  return 4 + 60 / covered;
}
constexpr int kFewestPixels = 4;         // of a cell whose colour is compared
constexpr int kCellMargin = 12;          // edge pixels that may differ between devices
constexpr uint32_t kCoveredMargin = 24;  // the same in the whole image

constexpr std::array<std::pair<Look, const char*>, 4> kLooks{
    {{Look::own, "own"}, {Look::plain, "plain"}, {Look::nothing, "nothing"}, {Look::refused, "refused"}}};

std::string hex(const Grid& grid) {
  std::string text;
  char bytes[9];
  for (const Cell& cell : grid) {
    std::snprintf(bytes, sizeof bytes, "%02x%02x%02x%02x", cell.color[0], cell.color[1], cell.color[2],
                  cell.covered);
    text += bytes;
  }
  return text;
}

std::optional<Grid> grid_from(const std::string& text) {
  Grid grid{};
  if (text.size() != 8 * grid.size() || text.find_first_not_of("0123456789abcdef") != std::string::npos)
    return {};
  for (size_t i = 0; i < grid.size(); ++i) {
    const unsigned long value = std::strtoul(text.substr(8 * i, 8).c_str(), nullptr, 16);
    for (size_t c = 0; c < 3; ++c) grid[i].color[c] = static_cast<uint8_t>(value >> (24 - 8 * c));
    grid[i].covered = static_cast<uint8_t>(value);
  }
  return grid;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  size_t begin = 0;
  for (size_t bar; (bar = line.find(" | ", begin)) != std::string::npos; begin = bar + 3)
    fields.push_back(line.substr(begin, bar - begin));
  fields.push_back(line.substr(begin));
  return fields;
}

std::optional<AssetOracle> oracle_from(const std::vector<std::string>& fields) {
  if (fields.size() != 8) return {};
  AssetOracle oracle;
  const auto* look =
      std::find_if(kLooks.begin(), kLooks.end(), [&](auto& l) { return fields[1] == l.second; });
  if (look == kLooks.end()) return {};
  oracle.look = look->first;
  oracle.own_camera = fields[2] == "camera";
  if (fields[2] != "framed" && !oracle.own_camera) {
    std::istringstream eye(fields[2]);
    oracle.eye.emplace();
    if (!(eye >> oracle.eye->x >> oracle.eye->y >> oracle.eye->z)) return {};
  }
  std::istringstream counts(fields[3]), covered(fields[4]);
  if (!(counts >> oracle.counts.triangles >> oracle.counts.lines >> oracle.counts.points)) return {};
  if (!(covered >> oracle.covered)) return {};
  const std::optional<Grid> grid = grid_from(fields[5]);
  if (!grid) return {};
  oracle.grid = *grid;
  oracle.sample = grid_from(fields[6]);
  if (!oracle.sample && fields[6] != "-") return {};
  oracle.note = fields[7] == "-" ? "" : fields[7];
  if (oracle.look != Look::own && oracle.note.empty()) return {};  // the note holds the reason
  return oracle;
}

}  // namespace

MeasuredImage describe_picture(sinks::FrameImage image, const sinks::FrameImage& blank,
                               const contact_sheet::DrawnCounts& counts) {
  MeasuredImage picture;
  picture.counts = counts;
  constexpr uint32_t kCellSide = kAssetSide / kCells;
  std::array<std::array<uint32_t, 3>, size_t{kCells} * kCells> sums{};
  std::array<uint32_t, size_t{kCells} * kCells> covered{};
  for (uint32_t i = 0; i < kAssetSide * kAssetSide; ++i) {
    const uint8_t* color = image.rgba8.data() + size_t{4} * i;
    if (std::equal(color, color + 3, blank.rgba8.data() + size_t{4} * i)) continue;
    const size_t cell = size_t{i / kAssetSide / kCellSide} * kCells + i % kAssetSide / kCellSide;
    for (size_t c = 0; c < 3; ++c) sums[cell][c] += color[c];
    ++covered[cell];
    ++picture.covered;
  }
  for (size_t cell = 0; cell < covered.size(); ++cell) {
    picture.grid[cell].covered = static_cast<uint8_t>(std::min(covered[cell], 255u));
    for (size_t c = 0; c < 3 && covered[cell] > 0; ++c)
      picture.grid[cell].color[c] = static_cast<uint8_t>(sums[cell][c] / covered[cell]);
  }
  picture.image = std::move(image);
  return picture;
}

std::string disagreement(const AssetOracle& oracle, const MeasuredImage& picture) {
  std::ostringstream text;
  const contact_sheet::DrawnCounts& is = picture.counts;
  const contact_sheet::DrawnCounts& wanted = oracle.counts;
  if (is != wanted) {
    text << is.triangles << " triangles, " << is.lines << " lines, " << is.points << " points are drawn, not "
         << wanted.triangles << ", " << wanted.lines << ", " << wanted.points << "; ";
  }
  if (std::max(picture.covered, oracle.covered) - std::min(picture.covered, oracle.covered) > kCoveredMargin)
    text << picture.covered << " pixels are covered, not " << oracle.covered << "; ";
  if (oracle.look == Look::nothing && picture.covered != 0) text << "something is to be seen; ";
  uint32_t cells_off = 0;
  for (size_t cell = 0; cell < oracle.grid.size(); ++cell) {
    const Cell& seen = picture.grid[cell];
    const Cell& expected = oracle.grid[cell];
    const int fewer = std::min(seen.covered, expected.covered);
    int color_off = 0;
    for (size_t c = 0; c < 3; ++c)
      color_off = std::max(color_off, std::abs(int{seen.color[c]} - int{expected.color[c]}));
    if (std::abs(int{seen.covered} - int{expected.covered}) <= kCellMargin &&
        (fewer < kFewestPixels || color_off <= color_margin(fewer)))
      continue;
    if (cells_off++ > 0) continue;
    text << "cell " << cell % kCells << ", " << cell / kCells << " has " << int{seen.covered}
         << " covered pixels, not " << int{expected.covered} << ", and its colour is off by " << color_off
         << "/255; ";
  }
  if (cells_off > 1) text << "and " << cells_off - 1 << " more cells are off; ";
  return text.str();
}

double distance_to_sample(const Grid& sample, const MeasuredImage& picture) {
  constexpr int kEnoughPixels = 64;
  double sum_sample = 0, sum_picture = 0, difference = 0;
  for (const bool sums_known : {false, true}) {
    for (size_t cell = 0; cell < sample.size(); ++cell) {
      if (picture.grid[cell].covered < kEnoughPixels) continue;
      for (size_t c = 0; c < 3; ++c) {
        const double theirs = sample[cell].color[c], ours = picture.grid[cell].color[c];
        if (sums_known) {
          difference += std::abs(theirs / sum_sample - ours / sum_picture);
        } else {
          sum_sample += theirs;
          sum_picture += ours;
        }
      }
    }
    if (sum_sample == 0 || sum_picture == 0) return 1;
  }
  return difference;
}

AssetTable read_asset_table(const std::filesystem::path& file) {
  AssetTable table;
  std::ifstream lines(file);
  EXPECT_TRUE(lines.good()) << file << " cannot be read";
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> fields = fields_of(line);
    const std::optional<AssetOracle> oracle = oracle_from(fields);
    EXPECT_TRUE(oracle.has_value()) << "not a row of the table: " << line;
    if (!oracle) continue;
    EXPECT_TRUE(table.emplace(fields[0], *oracle).second) << fields[0] << " has two rows";
  }
  return table;
}

std::string table_row(const std::string& asset, const AssetOracle& oracle) {
  std::ostringstream row;
  row << asset << " | ";
  for (const auto& [look, name] : kLooks) row << (look == oracle.look ? name : "");
  row << " | ";
  if (oracle.eye) {
    row << oracle.eye->x << ' ' << oracle.eye->y << ' ' << oracle.eye->z;
  } else {
    row << (oracle.own_camera ? "camera" : "framed");
  }
  row << " | " << oracle.counts.triangles << ' ' << oracle.counts.lines << ' ' << oracle.counts.points
      << " | " << oracle.covered << " | " << hex(oracle.grid) << " | "
      << (oracle.sample ? hex(*oracle.sample) : "-") << " | " << (oracle.note.empty() ? "-" : oracle.note);
  return row.str();
}

}  // namespace fire3dv::test

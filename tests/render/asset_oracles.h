// What the picture of an asset has to look like, in numbers that stand in a table (asset_oracles.txt): what
// is drawn, how much of the image it covers, and the mean colours of what is covered in each of
// a grid of cells. The margins are narrow:
// a blank image, or one with default materials, is another picture, and the tests prove that for each row.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "tools/contact_sheet/asset_drawer.h"

namespace fire3dv::test {

constexpr uint32_t kAssetSide = 96;  // pixels of the square images that the table is about
constexpr uint32_t kCells = 6;       // along each side

struct Cell {
  std::array<uint8_t, 3> color{};  // mean of the pixels that the asset covers
  uint8_t covered = 0;             // pixels, 255 at most
};
using Grid = std::array<Cell, size_t{kCells} * kCells>;

enum class Look {
  own,      // with default materials, without vertex colours, it would be another picture
  plain,    // it would not: the note says why
  nothing,  // there is nothing to see, and the note says why
  refused,  // valid, but not loaded: the note is part of the reason given
};

struct AssetOracle {
  Look look = Look::own;
  // Looking at the origin: the eye of the collection's own picture, or one that sees what is small in its
  // scene. Else the scene's first camera, or framed whole.
  std::optional<glm::vec3> eye;
  bool own_camera = false;
  contact_sheet::DrawnCounts counts;
  uint32_t covered = 0;  // pixels
  Grid grid{};
  // The collection's own picture, taken from the same eye with another program under other light: its colours
  // where the asset covers pixels here.
  std::optional<Grid> sample;
  std::string note;
};

// What was drawn, to be held against an oracle.
struct AssetPicture {
  sinks::FrameImage image;
  contact_sheet::DrawnCounts counts;
  uint32_t covered = 0;
  Grid grid{};
};
AssetPicture describe_picture(sinks::FrameImage image, const sinks::FrameImage& blank,
                              const contact_sheet::DrawnCounts& counts);

// Empty when it is as the oracle says; else what is not.
std::string disagreement(const AssetOracle& oracle, const AssetPicture& picture);

// How far the surface's colours are from those of the sample once both are equally bright: the mean
// difference as a share of the mean. Another program's light leaves some; another texture, colour or place
// leaves more.
double distance_to_sample(const Grid& sample, const AssetPicture& picture);

// Rows by the asset's name. A line that cannot be read fails the calling test.
using AssetTable = std::map<std::string, AssetOracle>;
AssetTable read_asset_table(const std::filesystem::path& file);
std::string table_row(const std::string& asset, const AssetOracle& oracle);

}  // namespace fire3dv::test

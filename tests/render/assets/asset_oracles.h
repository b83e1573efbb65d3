// Numeric oracle for images of assets (asset_oracles.txt): drawn primitives, covered pixels, and the mean
// colour of the covered pixels in each cell of a grid. The margins are narrow: for each row the tests prove
// that a blank image and one with default materials fail.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "tools/lab/contact_sheet/asset_drawer.h"

namespace fire3dv::test {

constexpr uint32_t kAssetSide = 96;  // pixels; side of the square images of the table
constexpr uint32_t kCells = 6;       // along each side

struct Cell {
  std::array<uint8_t, 3> color{};  // mean of the pixels that the asset covers
  uint8_t covered = 0;             // pixels, 255 at most
};
using Grid = std::array<Cell, size_t{kCells} * kCells>;

enum class Look {
  own,      // default materials without vertex colours give another image
  plain,    // default materials give the same image; the note says why
  nothing,  // nothing is visible, and the note says why
  refused,  // valid, but not loaded: the error message contains the note
};

struct AssetOracle {
  Look look = Look::own;
  // Camera position; it looks at the origin: the eye of the collection's sample image, or one close to small
  // objects. Otherwise the scene's first camera, or the scene framed whole.
  std::optional<glm::vec3> eye;
  bool own_camera = false;
  contact_sheet::DrawnCounts counts;
  uint32_t covered = 0;  // pixels
  Grid grid{};
  // The collection's sample image from the same eye, rendered by another program with other lights: its
  // colours in the cells that the asset covers here.
  std::optional<Grid> sample;
  std::string note;
};

// Measured image of an asset, for comparison with an oracle.
struct MeasuredImage {
  sinks::FrameImage image;
  contact_sheet::DrawnCounts counts;
  uint32_t covered = 0;
  Grid grid{};
};
MeasuredImage describe_picture(sinks::FrameImage image, const sinks::FrameImage& blank,
                               const contact_sheet::DrawnCounts& counts);

// Returns the differences from the oracle; empty if the image agrees.
std::string disagreement(const AssetOracle& oracle, const MeasuredImage& picture);

// Returns the distance of the colours to those of the sample at equal brightness: mean difference divided by
// the mean. Other lighting leaves a small distance; another texture, colour or position a larger one.
double distance_to_sample(const Grid& sample, const MeasuredImage& picture);

// Rows by asset name. An invalid line fails the calling test.
using AssetTable = std::map<std::string, AssetOracle>;
AssetTable read_asset_table(const std::filesystem::path& file);
std::string table_row(const std::string& asset, const AssetOracle& oracle);

}  // namespace fire3dv::test

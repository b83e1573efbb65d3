// Tables and metadata of a LeRobot v3 data set of one episode: columns of the frames, info.json, stats.json,
// and the Parquet files of frames, episodes and tasks.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/lerobot/statistics.h"
#include "renderer/dataset/lerobot/videos.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::dataset {

constexpr const char* kDataName = "data/chunk-000/file-000.parquet";
constexpr const char* kEpisodesName = "meta/episodes/chunk-000/file-000.parquet";
constexpr const char* kTasksName = "meta/tasks.parquet";
constexpr const char* kInfoName = "meta/info.json";
constexpr const char* kStatisticsName = "meta/stats.json";

// Column of the frames.
struct FrameColumn {
  std::string key, dtype;          // "float32", "float64", "int64"
  size_t components = 1;           // of each row
  std::vector<std::string> names;  // of the components; empty: none
  std::vector<double> values;      // row after row
};

// lines: of all images, as is_image_line() accepts them; frames: at least one. The action of a frame is the
// state of the next one, and of the last frame its own.
std::vector<FrameColumn> frame_columns(const Description& description, const offline::FrameLines& lines);

// Names and contents of the files; videos: of the cameras, in their order.
std::vector<std::pair<std::string, std::vector<uint8_t>>> encode_tables(
    const Description& description, const std::vector<FrameColumn>& columns,
    const std::vector<CameraStatistics>& videos);

}  // namespace fire3dv::dataset

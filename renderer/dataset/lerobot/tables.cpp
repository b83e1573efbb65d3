#include "renderer/dataset/lerobot/tables.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/dataset/lerobot/depth_codes.h"
#include "renderer/dataset/parquet/parquet_file.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

// Feature of info.json with its statistics.
struct Feature {
  std::string key;
  ordered_json description;
  std::vector<uint32_t> statistics_shape;
  const FeatureStatistics* statistics;
};

uint64_t rows_of(const std::vector<FrameColumn>& columns) {
  return columns.back().values.size() / columns.back().components;
}

std::vector<double> numbers_at(const ordered_json& line, const char* name) {
  return line.at(name).get<std::vector<double>>();
}

// 4x4 by rows, metres.
std::vector<double> world_from_camera(const ordered_json& line) {
  const std::vector<double> rotation = numbers_at(line, "cam_R_w2c"), t = numbers_at(line, "cam_t_w2c");
  std::vector<double> pose;
  for (size_t row = 0; row < 3; ++row) {
    double place = 0;
    for (size_t i = 0; i < 3; ++i) {
      pose.push_back(rotation.at(3 * i + row));
      place -= rotation.at(3 * i + row) * t.at(i) / kMillimetres;
    }
    pose.push_back(place == 0 ? 0.0 : place);  // no minus zero
  }
  pose.insert(pose.end(), {0, 0, 0, 1});
  return pose;
}

void append(std::vector<double>& to, const std::vector<double>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

// The state of the next frame.
FrameColumn action_of(const FrameColumn& state) {
  FrameColumn action = state;
  action.key = "action";
  const auto row = static_cast<std::ptrdiff_t>(state.components);
  std::copy(state.values.begin() + row, state.values.end(), action.values.begin());
  return action;
}

ParquetColumn encode(const FrameColumn& column) {
  ParquetColumn encoded;
  encoded.name = column.key;
  if (column.components > 1) encoded.shape = {static_cast<uint32_t>(column.components)};
  const auto convert = [&]<typename T>(std::vector<T> values) {
    for (const double value : column.values) values.push_back(static_cast<T>(value));
    encoded.values = std::move(values);
  };
  if (column.dtype == "float32")
    convert(std::vector<float>());
  else if (column.dtype == "int64")
    convert(std::vector<int64_t>());
  else
    convert(std::vector<double>());
  return encoded;
}

ordered_json video_info(const Description& description, bool is_depth) {
  const Episode& episode = description.episode;
  ordered_json info = {{"video.height", description.height},
                       {"video.width", description.width},
                       {"video.codec", is_depth ? "hevc" : "h264"},
                       {"video.pix_fmt", is_depth ? "gray12le" : "yuv420p"},
                       {"video.fps", episode.fps},
                       {"video.channels", is_depth ? 1 : 3},
                       {"has_audio", false},
                       {"video.g", kKeyFrameInterval}};
  if (is_depth) {
    const DepthCodes codes = DepthCodes::of(description);
    info["video.extra_options"] = {{"x265-params", "lossless=1"}};
    info["video.depth_min"] = codes.min_m;
    info["video.depth_max"] = codes.max_m;
    info["video.shift"] = codes.shift_m;
    info["video.use_log"] = codes.is_logarithmic;
    info["depth_unit"] = "m";  // of the statistics
  }
  info["is_depth_map"] = is_depth;
  return info;
}

Feature video_feature(const Description& description, const std::string& key,
                      const FeatureStatistics& statistics, bool is_depth) {
  const uint32_t channels = is_depth ? 1 : 3;
  return {key,
          {{"dtype", "video"},
           {"shape", {description.height, description.width, channels}},
           {"names", {"height", "width", "channels"}},
           {"info", video_info(description, is_depth)}},
          {channels, 1, 1},
          &statistics};
}

ordered_json info_of(const Description& description, const std::vector<Feature>& features, uint64_t frames) {
  ordered_json info = {{"codebase_version", "v3.0"},
                       {"robot_type", nullptr},
                       {"total_episodes", 1},
                       {"total_frames", frames},
                       {"total_tasks", 1},
                       {"chunks_size", 1000},
                       {"data_files_size_in_mb", 100},
                       {"video_files_size_in_mb", 200},
                       {"fps", description.episode.fps},
                       {"splits", {{"train", "0:1"}}},
                       {"data_path", "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"},
                       {"video_path", "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"},
                       {"features", ordered_json::object()}};
  for (const Feature& feature : features) info["features"][feature.key] = feature.description;
  return info;
}

// Lists in lists of one element each, but for the outermost.
ordered_json nested(const std::vector<double>& values, const std::vector<uint32_t>& shape) {
  ordered_json list = ordered_json::array();
  for (const double value : values) {
    ordered_json element = value;
    for (size_t i = 1; i < shape.size(); ++i) element = ordered_json::array({element});
    list.push_back(element);
  }
  return list;
}

ordered_json statistics_json(const std::vector<Feature>& features) {
  ordered_json all = ordered_json::object();
  for (const Feature& feature : features) {
    ordered_json& own = all[feature.key];
    for (size_t i = 0; i < kStatisticNames.size(); ++i)
      own[kStatisticNames[i]] = nested(feature.statistics->values[i], feature.statistics_shape);
    own["count"] = ordered_json::array({feature.statistics->count});
  }
  return all;
}

ParquetColumn integer(const std::string& name, uint64_t value) {
  return {name, {}, std::vector<int64_t>{static_cast<int64_t>(value)}};
}

std::vector<ParquetColumn> episode_columns(const Description& description,
                                           const std::vector<Feature>& features, uint64_t frames) {
  std::vector<ParquetColumn> columns{
      integer("episode_index", 0),        {"tasks", {1}, std::vector<std::string>{description.episode.task}},
      integer("length", frames),          integer("data/chunk_index", 0),
      integer("data/file_index", 0),      integer("dataset_from_index", 0),
      integer("dataset_to_index", frames)};
  const double end_s = static_cast<double>(frames) / description.episode.fps;
  for (const Feature& feature : features) {
    if (feature.description["dtype"] != "video") continue;
    const std::string begin = "videos/" + feature.key + "/";
    columns.push_back(integer(begin + "chunk_index", 0));
    columns.push_back(integer(begin + "file_index", 0));
    columns.push_back({begin + "from_timestamp", {}, std::vector<double>{0}});
    columns.push_back({begin + "to_timestamp", {}, std::vector<double>{end_s}});
  }
  for (const Feature& feature : features) {
    const std::string begin = "stats/" + feature.key + "/";
    for (size_t i = 0; i < kStatisticNames.size(); ++i)
      columns.push_back(
          {begin + kStatisticNames[i], feature.statistics_shape, feature.statistics->values[i]});
    columns.push_back(
        {begin + "count", {1}, std::vector<int64_t>{static_cast<int64_t>(feature.statistics->count)}});
  }
  columns.push_back(integer("meta/episodes/chunk_index", 0));
  columns.push_back(integer("meta/episodes/file_index", 0));
  return columns;
}

// The task is the index of a pandas.DataFrame, which LeRobot looks tasks up by.
std::vector<uint8_t> encode_tasks(const std::string& task) {
  const auto column = [](const char* name, const char* pandas_type, const char* numpy_type) {
    return ordered_json{{"name", name},
                        {"field_name", name},
                        {"pandas_type", pandas_type},
                        {"numpy_type", numpy_type},
                        {"metadata", nullptr}};
  };
  const ordered_json labels = {{"name", nullptr},
                               {"field_name", nullptr},
                               {"pandas_type", "unicode"},
                               {"numpy_type", "object"},
                               {"metadata", {{"encoding", "UTF-8"}}}};
  const ordered_json pandas = {{"index_columns", ordered_json::array({"task"})},
                               {"column_indexes", ordered_json::array({labels})},
                               {"columns", ordered_json::array({column("task_index", "int64", "int64"),
                                                                column("task", "unicode", "object")})},
                               {"attributes", ordered_json::object()},
                               {"creator", {{"library", "FIRE-3DV"}, {"version", "1"}}},
                               {"pandas_version", "2.0.0"}};
  return encode_parquet({integer("task_index", 0), {"task", {}, std::vector<std::string>{task}}}, 1,
                        {{"pandas", pandas.dump()}});
}

std::vector<uint8_t> bytes_of(const ordered_json& json) {
  const std::string text = json.dump(4) + "\n";
  return {text.begin(), text.end()};
}

}  // namespace

std::vector<FrameColumn> frame_columns(const Description& description, const offline::FrameLines& lines) {
  const Episode& episode = description.episode;
  constexpr size_t kIntrinsics = 9, kPose = 16;
  FrameColumn state{"observation.state", "float32", episode.state_names.size(), episode.state_names, {}};
  FrameColumn environment{"observation.environment_state",
                          "float32",
                          episode.environment_names.size(),
                          episode.environment_names,
                          {}};
  FrameColumn timestamp{"timestamp", "float32", 1, {}, {}}, frame_index{"frame_index", "int64", 1, {}, {}},
      episode_index{"episode_index", "int64", 1, {}, {}}, task_index{"task_index", "int64", 1, {}, {}};
  std::vector<FrameColumn> cameras;
  for (size_t camera = 0; camera < description.cameras.size(); ++camera) {
    const std::string begin = "camera." + std::to_string(camera) + ".";
    cameras.push_back({begin + "intrinsics", "float64", kIntrinsics, {}, {}});
    cameras.push_back({begin + "world_from_camera", "float64", kPose, {}, {}});
  }
  for (const auto& [image, text] : lines) {
    const auto line = ordered_json::parse(text);
    const size_t camera = description.index_of_camera(image);
    append(cameras[2 * camera].values, numbers_at(line, "cam_K"));
    append(cameras[2 * camera + 1].values, world_from_camera(line));
    if (camera != 0) continue;
    const auto frame = static_cast<double>(description.frame_of(image));
    if (!episode.state_names.empty()) append(state.values, numbers_at(line, "state"));
    if (!episode.environment_names.empty()) append(environment.values, numbers_at(line, "environment_state"));
    timestamp.values.push_back(frame / episode.fps);
    frame_index.values.push_back(frame);
    episode_index.values.push_back(0);
    task_index.values.push_back(0);
  }
  FrameColumn index = frame_index;
  index.key = "index";
  std::vector<FrameColumn> columns;
  if (!episode.state_names.empty()) columns.push_back(state);
  if (!episode.environment_names.empty()) columns.push_back(std::move(environment));
  if (!episode.state_names.empty()) columns.push_back(action_of(state));
  for (FrameColumn& column : cameras) columns.push_back(std::move(column));
  for (FrameColumn* column : {&timestamp, &frame_index, &episode_index, &index, &task_index})
    columns.push_back(std::move(*column));
  return columns;
}

std::vector<std::pair<std::string, std::vector<uint8_t>>> encode_tables(
    const Description& description, const std::vector<FrameColumn>& columns,
    const std::vector<CameraStatistics>& videos) {
  const uint64_t frames = rows_of(columns);
  std::vector<FeatureStatistics> statistics;
  statistics.reserve(columns.size());  // features refer to them
  std::vector<Feature> features;
  std::vector<ParquetColumn> data;
  for (const FrameColumn& column : columns) {
    statistics.push_back(statistics_of(column.values, column.components));
    const auto components = static_cast<uint32_t>(column.components);
    features.push_back({column.key,
                        {{"dtype", column.dtype},
                         {"shape", ordered_json::array({components})},
                         {"names", column.names.empty() ? ordered_json() : ordered_json(column.names)}},
                        {components},
                        &statistics.back()});
    data.push_back(encode(column));
  }
  const std::vector<CameraKeys> keys = camera_keys(description);
  for (size_t camera = 0; camera < keys.size(); ++camera) {
    features.push_back(video_feature(description, keys[camera].color, videos[camera].color, false));
    features.push_back(video_feature(description, keys[camera].depth, videos[camera].depth, true));
  }
  std::vector<std::pair<std::string, std::vector<uint8_t>>> files;
  files.emplace_back(kDataName, encode_parquet(data, frames, {}));
  files.emplace_back(kEpisodesName, encode_parquet(episode_columns(description, features, frames), 1, {}));
  files.emplace_back(kTasksName, encode_tasks(description.episode.task));
  files.emplace_back(kStatisticsName, bytes_of(statistics_json(features)));
  files.emplace_back(kInfoName, bytes_of(info_of(description, features, frames)));
  return files;
}

}  // namespace fire3dv::dataset

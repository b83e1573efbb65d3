// Videos of a LeRobot data set: colours (H.264) and depth (H.265, lossless, 12 bits) of each camera.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/dataset/lerobot/statistics.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::dataset {

constexpr int kKeyFrameInterval = 2;  // LeRobot's: training reads single images

// Names of the features of a camera: "observation.images.front" and "observation.images.front_depth".
struct CameraKeys {
  std::string color, depth;
};
std::vector<CameraKeys> camera_keys(const Description& description);

// Relative to the set's folder.
std::string video_folder(const std::string& key);
std::string video_name(const std::string& key);

sinks::VideoSettings video_settings(const Description& description, const std::filesystem::path& path,
                                    bool is_depth);

// File of the depth codes of an image, relative to the set's folder.
std::string depth_name(const Layout& layout, const Description& description, uint64_t image);

// Colours from 0 to 1, three components; depth in metres.
struct CameraStatistics {
  FeatureStatistics color, depth;
};
// Writes the videos of all cameras from the images' files, which are untrusted. frames: at least one.
Result<std::vector<CameraStatistics>> write_videos(const std::filesystem::path& folder, const Layout& layout,
                                                   const Description& description, uint64_t frames);

}  // namespace fire3dv::dataset

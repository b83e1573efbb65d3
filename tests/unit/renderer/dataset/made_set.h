// Data sets of made images, drawn by nobody: two instances of 2x2 pixels on a wall without labels.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "renderer/dataset/dataset_format.h"
#include "renderer/offline/frame_folder.h"

namespace fire3dv::dataset {

constexpr uint32_t kWidth = 8, kHeight = 6;
constexpr uint64_t kImages = 4;  // of two cameras

inline Description made_description(const std::string& format) {
  Description description;
  description.format = format;
  description.command = "fire3dv dataset x.glb --out DIR";
  description.width = kWidth;
  description.height = kHeight;
  description.cameras = {"front", "../side/\n"};
  for (uint32_t i = 0; i < 2; ++i) {
    Object object;
    object.id = i + 1;
    object.name = "mesh " + std::to_string(i);
    object.diameter_mm = 10;
    description.objects.push_back(object);
    Instance instance;
    instance.number = 2 + 3 * i;
    instance.object = i;
    instance.semantic = 7;
    instance.name = i ? "b" : "a\"<";
    instance.path = "root/" + instance.name;
    description.instances.push_back(instance);
  }
  Keypoint point;
  point.name = "tip";
  point.instance = 2;
  point.node = 1;
  description.keypoints.push_back(point);
  return description;
}

// All planes that any format takes.
inline sinks::FrameImage made_image(uint64_t number) {
  constexpr size_t kPixels = size_t{kWidth} * kHeight;
  sinks::FrameImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.frame_index = number;
  image.camera = "front";
  for (size_t i = 0; i < kPixels; ++i) {
    const auto value = static_cast<uint8_t>(7 * i + number);
    image.rgba8.insert(image.rgba8.end(), {value, 100, static_cast<uint8_t>(255 - value), 255});
  }
  std::vector<float> depth(kPixels, 2.0f);
  depth[kPixels - 1] = INFINITY;
  std::vector<uint32_t> instances(kPixels, 1), classes(kPixels, 0);
  image.amodal.emplace();
  const uint32_t rows = kHeight;
  for (uint32_t i = 0; i < 2; ++i) {
    const uint32_t left = 1 + 3 * i;
    image.amodal->records.push_back({2 + 3 * i, 7, left, 1, left + 2, 3, 4, 4, 0, 0});
    std::vector<uint8_t> mask(rows);  // one byte a row
    for (uint32_t y = 1; y < 3; ++y) {
      for (uint32_t x = left; x < left + 2; ++x) {
        instances[size_t{y} * kWidth + x] = 2 + 3 * i;
        classes[size_t{y} * kWidth + x] = 7;
        depth[size_t{y} * kWidth + x] = 1.0f + 0.5f * static_cast<float>(i);
        mask[y] = static_cast<uint8_t>(mask[y] | (0x80u >> x));
      }
    }
    image.amodal->masks.insert(image.amodal->masks.end(), mask.begin(), mask.end());
  }
  const auto add = [&](wire::ImageOutput output, const auto& values) {
    sinks::FramePlane plane{output, std::vector<uint8_t>(values.size() * sizeof values[0])};
    std::memcpy(plane.bytes.data(), values.data(), plane.bytes.size());
    image.planes.push_back(std::move(plane));
  };
  add(wire::kDepthF32, depth);
  add(wire::kInstanceU32, instances);
  add(wire::kSemanticU32, classes);
  constexpr uint16_t kOne = 0x3c00;  // half float
  std::vector<uint16_t> normals(4 * kPixels);
  for (size_t i = 2; i < normals.size(); i += 4) normals[i] = kOne;
  add(wire::kNormal, normals);
  return image;
}

inline ImagePoses made_poses() {
  ImagePoses poses;
  poses.intrinsics = {10, 10, (kWidth - 1) / 2.0f, (kHeight - 1) / 2.0f, {kWidth, kHeight}};
  for (int i = 0; i < 2; ++i) {
    glm::dmat4 pose(1);
    pose[3] = glm::dvec4(-0.2 + 0.3 * i, -0.1, 1.0 + 0.5 * i, 1);
    poses.world_from_instance.push_back(pose);
  }
  poses.world_from_keypoint_node.push_back(poses.world_from_instance.front());
  return poses;
}

inline offline::Manifest made_manifest(uint32_t shard = 1, uint32_t shards = 1) {
  offline::Manifest manifest;
  manifest.settings = {{"scene", "made"}};
  manifest.times.frames = kImages / 2;
  manifest.cameras = 2;
  manifest.width = kWidth;
  manifest.height = kHeight;
  manifest.shard = shard;
  manifest.shards = shards;
  return manifest;
}

class MadeSet : public ::testing::Test {
 protected:
  MadeSet() {
    std::string name = (std::filesystem::temp_directory_path() / "fire3dv-set-XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  ~MadeSet() override { std::filesystem::remove_all(root_); }

  std::shared_ptr<DatasetFormat> format_of(const Description& description) {
    auto written = as_written(description);
    EXPECT_TRUE(written.ok());
    std::vector<offline::FolderFile> files;
    auto layout = make_layout(description.format);
    for (const std::string& name : layout->static_names(description)) files.push_back({name, {1, 2, 3}});
    return std::make_shared<DatasetFormat>(std::move(*written), std::move(layout), std::move(files));
  }

  // Draws what is missing, as `fire3dv dataset` does. Returns the error. completes: writes the files of the
  // whole set, too.
  std::string run(const std::filesystem::path& folder, const Description& description,
                  const offline::Manifest& manifest = made_manifest(), bool completes = true) {
    auto format = format_of(description);
    auto set = offline::FrameFolder::open(folder, manifest, format);
    if (!set) return set.error().message;
    existing_ = (*set)->existing_frames();
    const offline::Part part = manifest.part();
    if (existing_ < part.frames) {
      if (auto begun = (*set)->begin({}); !begun) return begun.error().message;
      for (uint64_t image = part.first; image < part.first + part.frames; ++image) {
        if ((*set)->has(image)) continue;
        format->add_poses(image, made_poses());
        if (auto taken = (*set)->consume(made_image(image)); !taken) return taken.error().message;
      }
    }
    if (auto finished = (*set)->finish(); !finished) return finished.error().message;
    if (!completes) return {};
    if (auto completed = (*set)->complete_run(); !completed) return completed.error().message;
    return {};
  }

  static std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // Contents of all files, by their names in the folder.
  static std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file())
        files[entry.path().lexically_relative(folder).string()] = text_of(entry.path());
    }
    return files;
  }
  static void write(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
  }

  std::filesystem::path root_;
  uint64_t existing_ = 0;  // images that the last run found
};

constexpr const char* kAllFormats[] = {"bop", "coco", "yolo", "c3vd", "folder", "hdf5", "webdataset"};

}  // namespace fire3dv::dataset

// Description of a data set (dataset.json): all that its final files need beside the labels of each image.
// Shards have the same one, so that `fire3dv join` needs no scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::dataset {

constexpr const char* kDescriptionName = "dataset.json";

// Model of one or more instances. Models of different sizes are different objects.
struct Object {
  uint32_t id = 1;  // from 1, without gaps
  std::string name;
  double diameter_mm = 0;  // largest distance of two vertices
  double min_mm[3]{}, size_mm[3]{};
  bool deforms = false;  // skin or morph targets: the model is the rest pose
};

// Labelled node with a mesh.
struct Instance {
  uint32_t number = 0;  // of instance planes: 1 + index of the node
  uint32_t object = 0;  // index into Description::objects
  uint32_t semantic = 0;
  std::string name, path;
  // world_from_node = rotation and translation, then this scale, at rest; a negative x mirrors.
  double scale[3]{1, 1, 1};
};

struct Keypoint {
  std::string name;
  uint32_t node = 0;  // index in the scene
  double node_from_point_m[3]{};
  uint32_t instance = 0;  // number of the node's instance; 0: the node has no labelled mesh
};

// Set of a format for policies; other formats have none.
struct Episode {
  uint32_t fps = 0;               // images of a camera a second; 0: another format
  std::string task;               // in words
  bool has_linear_depth = false;  // in steps of depth_unit_mm; false: logarithmic
  // Numbers of the state, and of the environment's state.
  std::vector<std::string> state_names, environment_names;
};

struct Description {
  std::string format;   // "bop"
  std::string command;  // makes the data set again; the same on all machines
  std::string license;  // empty: not stated
  uint32_t width = 0, height = 0;
  std::vector<std::string> cameras;
  double depth_unit_mm = 0.1;              // of 16-bit depth images with a scale
  uint64_t tar_bytes = uint64_t{1} << 30;  // most of an archive with several images
  double label_alpha = 0.5;                // blended surfaces with more alpha have labels
  uint32_t flow_frames = 0;                // flow is to the images so many frames later and earlier; 0: none
  bool is_stereo = false;                  // cameras are pairs, one after the other
  Episode episode;
  std::vector<Object> objects;
  std::vector<Instance> instances;  // ascending by number
  std::vector<Keypoint> keypoints;
  std::vector<std::string> warnings;       // of the scene
  std::vector<std::string> randomization;  // lines of the file; empty: nothing is randomised
  uint64_t seed = 0;

  // Null: not labelled.
  const Instance* find_instance(uint32_t number) const;
  uint32_t index_of_camera(uint64_t image) const { return static_cast<uint32_t>(image % cameras.size()); }
  uint64_t frame_of(uint64_t image) const { return image / cameras.size(); }
};

constexpr double kMillimetres = 1000;  // in a metre
constexpr size_t kMaxStateNumbers = 4096;
constexpr uint32_t kMaxFps = 100'000;

// The first names in quotation marks, for messages.
std::string list_names(const std::vector<std::string>& names);

std::string to_json(const Description& description);
// The description as read_description() would return it: texts are printable and of limited length. One run
// and joined parts therefore write the same bytes.
Result<Description> as_written(const Description& description);
Result<Description> read_description(const std::filesystem::path& folder);

}  // namespace fire3dv::dataset

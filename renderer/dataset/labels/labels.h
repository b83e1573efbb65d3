// Labels of one image: camera, instances with poses, boxes and masks, and keypoints, in OpenCV's conventions:
// camera axes right, down, forward; the centre of the top left pixel is (0, 0).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/labels/rle.h"
#include "renderer/dataset/randomize/distribution.h"
#include "renderer/passes/view/view.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::dataset {

// Poses at the moment of an image.
struct ImagePoses {
  passes::Intrinsics intrinsics;
  glm::dmat4 world_from_camera{1};              // OpenCV's axes; metres
  std::vector<glm::dmat4> world_from_instance;  // of the nodes of Description::instances
  std::vector<glm::dmat4> world_from_keypoint_node;
  std::optional<double> baseline_m;        // of a stereo pair: distance of the cameras, along their x axis
  DrawnValues drawn;                       // parameters of the randomisation
  double noise = 0;                        // to be added to the colours, see add_noise(); 0: none
  std::string stereo_fault;                // why the pair has no disparity; empty: it has
  std::vector<double> state, environment;  // numbers of Description::episode
};
// Baseline of a rectified pair: equal intrinsics and axes, displaced along x alone. The error says what is
// not. Poses in OpenCV's axes.
Result<double> find_baseline(const passes::Intrinsics& first, const glm::dmat4& world_from_first,
                             const passes::Intrinsics& second, const glm::dmat4& world_from_second);
// Pose of a camera of glTF (right, up, backward; its scale does not count) in OpenCV's axes.
glm::dmat4 opencv_pose(const glm::mat4& world_from_camera);

// Pixels, left and top inclusive.
struct Rectangle {
  int64_t left = 0, top = 0, width = 0, height = 0;
};

enum class KeypointState : uint8_t { outside, hidden, visible };

struct KeypointLabel {
  uint32_t index = 0;  // into Description::keypoints
  double x_px = 0, y_px = 0, depth_m = 0;
  KeypointState state = KeypointState::outside;
};

// The instance drawn alone, clipped at the image's border.
struct Silhouette {
  Runs pixels;
  Rectangle box;
  uint64_t px = 0, valid_px = 0;  // valid: with a depth in the format's depth image
  double visibility = 0;          // visible share
  bool is_truncated = false;      // a part of the instance is outside of the image
};

struct InstanceLabel {
  uint32_t number = 0;                        // of the instance plane
  uint32_t index = 0;                         // into Description::instances
  std::array<double, 9> camera_from_model{};  // rotation, by rows
  std::array<double, 3> camera_from_model_mm{};
  Runs visible;
  Rectangle visible_box;  // -1 in all fields: hidden
  uint64_t visible_px = 0;
  std::optional<Silhouette> silhouette;  // nullopt: not requested
  bool is_rescaled = false;              // drawn in another size than its model
};

struct ImageLabels {
  ImagePoses poses;
  std::vector<uint16_t> depth_units;  // 16-bit depth, if the format has it; 0: none, or beyond the range
  std::optional<uint64_t> beyond_range_px;  // surfaces whose depth does not fit
  double brightness = 0;                    // mean of sRGB colours, 0 to 255
  std::vector<InstanceLabel> instances;     // ascending by number
  std::vector<KeypointLabel> keypoints;
};

// Plane of an image. Null: it was not requested.
const sinks::FramePlane* find_plane(const sinks::FrameImage& image, wire::ImageOutput output);
// Elements of a plane of 4-byte numbers.
template <typename T>
std::vector<T> plane_values(const sinks::FrameImage& image, wire::ImageOutput output);

// image: with colours, depth and instances. With silhouettes, instances that others hide have labels, too.
// depth_unit_mm: of the format's 16-bit depth; nullopt: it has none.
ImageLabels find_labels(const sinks::FrameImage& image, ImagePoses poses, const Description& description,
                        const std::optional<double>& depth_unit_mm);

// Labels as JSON, for the line of the image: what formats need after the last image.
void add_json(const ImageLabels& labels, const Description& description, nlohmann::ordered_json& line);

}  // namespace fire3dv::dataset

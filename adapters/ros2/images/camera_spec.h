// Cameras that fire3dv-ros2 publishes, and the grammar of --camera.
//
//   --camera NAME[:=TOPIC][,KEY[=VALUE]]...
//   --camera 'front:=/cam/front,parent=tool0,xyz=0.1 0 0.05,rpy=0 0.4 0,size=1280x720,fov=1.2,depth'
//
// Frames as REP 103 has them: a body frame looks along +X with Z up; an optical frame looks along +Z with Y
// down. Units: metres, radians, pixels. Pixel coordinates follow OpenCV: the centre of the top left pixel is
// (0, 0).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace fire3dv::ros2 {

constexpr size_t kMaxTopicBytes = 200;  // DDS names end at 255 characters; ROS and the topics add to the base

enum class LabelSource { none, instance, semantic };
enum class Lens { none, plumb_bob, equidistant };

struct CameraSpec {
  std::string name;
  std::string topic;  // base of the topics, as is_valid_name (dds/names.h) takes it: "front", "/cam/front"
  std::string parent_frame;   // tf frame that carries the camera
  std::string optical_frame;  // frame_id of the images
  // Pose of the camera's body frame in the parent. Ignored if the parent is the optical frame itself.
  std::array<double, 3> xyz{}, rpy{};
  // Whether /tf_static of this program has parent -> optical; otherwise another program publishes that frame.
  bool publishes_frame = true;
  uint32_t width = 640, height = 480;
  double fov = 1.0472;                      // horizontal angle of view
  double fx = 0, fy = 0, cx = -1, cy = -1;  // fx 0: from fov; fy 0: fx; cx, cy negative: the centre
  double near_m = 0.05, far_m = 0;          // far 0: infinite
  Lens lens = Lens::none;
  std::array<double, 5> lens_coefficients{};  // plumb_bob: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4
  double rate_hz = 0;                         // images per second of wall time; 0: every pose frame
  bool depth = false, compressed = false;
  LabelSource labels = LabelSource::none;
  uint32_t jpeg_quality = 95;

  // The camera sits in the optical frame: parent_frame == optical_frame.
  bool is_in_optical_frame() const { return parent_frame == optical_frame; }
};

// Largest side of an image (protocol/SPEC.md, section 13).
inline constexpr uint32_t kMaxImageSide = 8192;
inline constexpr size_t kMaxCameras = 64;

// One --camera, with its settings in order, so that they can be applied to a <sensor> of the robot, too.
struct CameraOption {
  std::string name;
  std::string topic;  // empty: not given
  std::vector<std::pair<std::string, std::string>> settings;
};

// Parses and checks the value of --camera. The error names the key, the value and what would be valid.
Result<CameraOption> parse_camera_option(std::string_view text);

// Applies the settings of an option to a camera: to the defaults of all cameras, or to a <sensor>. The size
// comes first, whatever the order of the settings.
Result<CameraSpec> apply(const CameraOption& option, CameraSpec camera);

// Sets the size of the images. A projection in pixels, which belongs to the former size, is scaled: the
// camera sees what it saw.
void set_image_size(CameraSpec& camera, uint32_t width, uint32_t height);

// Parses "640x480".
Result<std::pair<uint32_t, uint32_t>> parse_image_size(std::string_view text);

// Replaces characters that ROS refuses in a topic: "head camera" becomes "head_camera".
std::string topic_from_name(std::string_view name);

// Parses exactly numbers.size() finite numbers between white space, and nothing else.
bool parse_numbers(std::string_view text, double* numbers, size_t count);

}  // namespace fire3dv::ros2

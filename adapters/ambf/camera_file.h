// Cameras as AMBF's world and model files define them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "adapters/ambf/launch.h"
#include "adapters/ambf/node_table.h"
#include "adapters/ambf/transform.h"

namespace fire3dv::ambf {

struct Intrinsics {
  double vertical_fov_rad = 0.7;
  double near_m = 0.1;
  double far_m = 10;
  bool two_eyes = false;  // AMBF draws the views of both side by side
  bool operator==(const Intrinsics&) const = default;
};

// Looks along -X, +Y right, +Z up, as AMBF's cameras do.
struct CameraDefinition {
  std::string key;     // as in AMBF's map of cameras
  std::string name;    // namespace and `name`
  std::string parent;  // key of an object, or a part of one; empty: the world
  Transform parent_from_camera;
  std::optional<Intrinsics> intrinsics;  // none: an orthographic camera
};

// Something that a file lists, by its place in AMBF's maps.
struct Listed {
  Kind kind = Kind::rigid_body;
  std::string key;
};

struct CameraDefinitions {
  std::vector<CameraDefinition> cameras;
  std::vector<Listed>
      listed;  // in the order in which AMBF adds them, cameras too: who is whose parent hangs on it
  std::vector<std::string> warnings;  // a sentence for each file or camera that could not be read
};

CameraDefinitions read_cameras(const Launch& launch);

// As AMBF joins the namespace of a file with that of a block of it.
std::string merge_namespaces(const std::string& outer, const std::string& inner);

// AMBF's frame of a camera that stands here and looks there; none where these give no direction.
std::optional<Transform> look_at(const double (&position)[3], const double (&target)[3],
                                 const double (&up)[3]);

}  // namespace fire3dv::ambf

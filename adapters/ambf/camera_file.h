// Camera definitions in AMBF's world and model files (ADF). Parsing never fails as a whole: unreadable files
// and cameras become warnings.
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
  bool two_eyes = false;  // stereo: AMBF draws the left and right views side by side
  bool operator==(const Intrinsics&) const = default;
};

// Camera in AMBF's camera frame: looks along -X, +Y right, +Z up.
struct CameraDefinition {
  std::string key;     // key in AMBF's camera map
  std::string name;    // namespace and `name`
  std::string parent;  // key of an object, or a part of one; empty: the world
  Transform parent_from_camera;
  std::optional<Intrinsics> intrinsics;  // empty: orthographic camera
};

// Object listed in a file, by its key in AMBF's maps.
struct Listed {
  Kind kind = Kind::rigid_body;
  std::string key;
};

struct CameraDefinitions {
  std::vector<CameraDefinition> cameras;
  std::vector<Listed>
      // All objects, cameras included, in AMBF's creation order, which decides parent look-ups.
      listed;
  std::vector<std::string> warnings;  // one message per unreadable file or camera
};

CameraDefinitions read_cameras(const Launch& launch);

// Joins the namespace of a file with the namespace of a block, as AMBF does.
std::string merge_namespaces(const std::string& outer, const std::string& inner);

// Returns the camera frame for a position, a target and an up vector. Empty for degenerate directions.
std::optional<Transform> look_at(const double (&position)[3], const double (&target)[3],
                                 const double (&up)[3]);

}  // namespace fire3dv::ambf

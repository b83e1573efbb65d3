// One function for each kind of description. Each warns of what it can do without (Model::warnings) and
// fails, naming file, line where it is known and remedy, where nothing can be shown. A description
// may name meshes anywhere; images are read only below the folders of the mesh that names them, of the
// description (URDF: and of its packages) and those that the user has named. All that MJCF names must lie
// below its folder and those. Regular files alone are opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

struct ReadOptions {
  // AMBF's -l: indices into a launch file's multibody configs, in this order. Empty: AMBF's own default.
  std::vector<size_t> launch_indices;
  bool launch_all = false;
  std::string name_space;  // AMBF's --ns
  // Where package:// URIs of URDF lead: folders that hold packages, or are packages. And what else a
  // description may read.
  std::vector<std::filesystem::path> package_folders;
  // Of all meshes together, and of AMBF's files together: what is over is left out, and that is said.
  size_t most_triangles = 20'000'000;
  uint64_t most_adf_bytes = uint64_t{64} << 20;
  // MJCF: each geom is a node of its own below its body, so that it can be hidden, coloured and told apart in
  // images by its name. Without, a body is one mesh, which is drawn faster.
  bool geoms_apart = false;
};

// An AMBF launch file, world file or model file (ADF). Nodes stand in AMBF's order and are called as AMBF's
// maps call its objects: namespace and block id, blanks kept, AMBF's index behind a name that is there
// already. A body's pose is in the world; of what has a parent, in the parent, whose child its node is. Poses
// are AMBF's own and so are frames: X of a camera's node points backwards and Z upwards, X of a light's node
// along its light. What glTF takes for a camera or a light stands in a child that turns it: NAME#view (a
// stereo camera has NAME#left and NAME#right too), NAME#light. The camera is called as AMBF calls it: NAME,
// NAME#left, NAME#right.
Result<Model> read_adf(const std::filesystem::path& file, const ReadOptions& options);
Result<Model> read_urdf(const std::filesystem::path& file, const ReadOptions& options);
// Through libmujoco's compiled model. Where this build has none, an error that says so.
Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions& options);

// By what the file is, not by what it is called. A description without lights gets one.
Result<Model> read_description(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace fire3dv::convert

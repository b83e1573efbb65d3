// Readers for description files, one function per format. Non-fatal problems go to Model::warnings; errors
// name file, line where known, and remedy.
//
// File access: meshes and files of MJCF may lie anywhere. Images must lie below the folder of their mesh, of
// the description (for URDF also of its packages, for SDF of its models and search paths), or a folder that
// the user named. All must lie below the description's folder or a named one if is_confined. Only regular
// files are opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "convert/model.h"

namespace fire3dv::convert {

enum class MeshUp : uint8_t { y, z };

struct ReadOptions {
  // AMBF's -l: indices into a launch file's multibody configs, in this order. Empty: AMBF's default.
  std::vector<size_t> launch_indices;
  bool launch_all = false;
  std::string name_space;  // AMBF's --ns
  // Folders for package:// URIs of URDF and model:// URIs of SDF: they contain packages or models, or are
  // some. MJCF files may lie below them, too.
  std::vector<std::filesystem::path> package_folders;
  // Values of xacro:arg by name, also for $(env) and $(optenv).
  std::map<std::string, std::string> xacro_arguments;
  std::string xacro_program;  // expands xacro instead of the built-in expander; empty: none runs
  bool dae_up = false;        // URDF, SDF: rotate DAE meshes by their up_axis
  // URDF, SDF: rotate glTF meshes to +Z up. Empty: URDF does, as RViz and Drake; SDF does not, as Gazebo.
  std::optional<bool> gltf_up;
  // Meshes without normals are smooth over edges up to this angle, 0 to 180; 0: flat. Empty: 37, as in
  // MuJoCo. MJCF always has MuJoCo's.
  std::optional<double> smooth_angle_deg;
  // URDF, SDF, MJCF: files must lie below the description's folder, a named one or (URDF, SDF) an installed
  // package, for descriptions that the user has not chosen. AMBF is refused then.
  bool is_confined = false;
  // Limits over all meshes and over all ADF files. What exceeds them is skipped with a warning.
  size_t max_triangles = 20'000'000;
  uint64_t max_adf_bytes = uint64_t{64} << 20;
  // MJCF: one node per geom below its body, so that geoms can be hidden, coloured and labelled individually.
  // Without it each body has one mesh, which draws faster.
  bool geoms_apart = false;
  // OBJ, STL and PLY as scenes. Empty: +Y up for OBJ, +Z up for others; metres.
  std::optional<MeshUp> mesh_up;
  std::optional<double> mesh_unit_m;
};

// Reads an AMBF launch, world or model file (ADF).
//
// Names: nodes have AMBF's order and map keys: namespace and block id, with blanks, and AMBF's number behind
// a duplicate.
//
// Frames: poses are in the world, or in the parent for nodes with one. Axes are AMBF's: +X of a camera node
// points backwards and +Z up; +X of a light node points along its light.
//
// Children: a rotated child node holds the glTF camera or light: NAME#view (stereo: also NAME#left and
// NAME#right), NAME#light. The cameras are named NAME, NAME#left and NAME#right.
Result<Model> read_adf(const std::filesystem::path& file, const ReadOptions& options);
// Reads URDF, and xacro, which it expands first.
Result<Model> read_urdf(const std::filesystem::path& file, const ReadOptions& options);
// Returns the text of a URDF, expanded if it is xacro. warnings receives those of the expansion.
Result<std::string> read_urdf_text(const std::filesystem::path& file, const ReadOptions& options,
                                   std::vector<std::string>& warnings);
// Reads MJCF as MuJoCo compiles it; needs no libmujoco.
Result<Model> read_mjcf(const std::filesystem::path& file, const ReadOptions& options);

// Reads an SDF file, or a model folder with a model.config, through libsdformat. Node names: sdf/names.h. Not
// thread-safe: it uses the process's console and settings of libsdformat. Fails with a message in builds
// without libsdformat.
Result<Model> read_sdf(const std::filesystem::path& file, const ReadOptions& options);

// By file extension: OBJ, STL, PLY, DAE, 3MF.
bool is_mesh_scene_name(const std::filesystem::path& file);
// Reads a mesh file as a scene, in a child process with limits on time and memory. Nodes, names, materials
// and vertex colours of the file are kept. Scales of its nodes are in the vertices, so that streams can pose
// them. Meshes without normals are smooth over edges below smooth_angle_deg.
Result<Model> read_mesh_scene(const std::filesystem::path& file, const ReadOptions& options);

// Detects the format from the contents; mesh files from the name, too. Adds a light to a description without
// any.
Result<Model> read_description(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace fire3dv::convert

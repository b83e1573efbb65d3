// A compiled MuJoCo model as a scene of the converter: node names, visibility, tendon geometry, and all that
// is drawn.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <cstddef>
#include <vector>

#include "convert/mjcf/scene/mjcf_names.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/scene/tendon_frames.h"
#include "convert/model.h"
#include "convert/readers.h"

namespace fire3dv::convert {

MjcfNames names_of(const mjModel& model);

// MuJoCo's precedence for geoms and tendons, in displayed (sRGB) colours: their own colour counts where it
// differs from the default.
std::array<float, 4> compiled_color(const mjModel& model, int material, const float* own);

// Excludes lights that are off, black or without direction.
bool is_scene_light(const mjModel& model, int light);

// Returns the maximum number of points of a drawn tendon; segments are one fewer. 0: not drawn (joint tendon,
// hidden group, transparent or without width).
size_t max_tendon_points(const mjModel& model, int tendon);

// Requires mj_tendon or more. Overwrites pieces; allocates nothing once it has capacity for
// max_tendon_points().
void tendon_pieces(const mjModel& model, const mjData& data, int tendon, std::vector<TendonPiece>& pieces);

// In the pose of `data`, which must have been computed (pose_mjcf, mj_forward or more).
MjcfScene compiled_scene(const mjModel& model, const mjData& data);

// Adds bodies, cameras, lights and tendons, named as in names_of(), in the pose of `data`.
void add_mjcf(const mjModel& model, const mjData& data, const ReadOptions& options, Model& to);

}  // namespace fire3dv::convert

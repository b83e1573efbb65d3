// Plan of one image: the passes that run. It is a value computed from settings, scene facts, outputs and
// inspection, without Vulkan, so that tests need no GPU.
#pragma once

#include <cstdint>

#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/shadows/shadow_plan.h"
#include "renderer/passes/view/camera_levels.h"
#include "renderer/settings/raster_settings.h"

namespace fire3dv::passes {

// Facts of settings, device and scene that decide a plan.
struct FrameFacts {
  settings::RasterPath raster_path = settings::RasterPath::visibility;  // never automatic
  bool can_write_samples = true;  // compute shading can write multisampled HDR colour for forward draws
  settings::LevelsOfDetail levels_of_detail = settings::LevelsOfDetail::automatic;
  bool scene_has_levels = false;
  bool has_forward_only = false;  // shown blended surfaces, lines or points
  bool has_markers = false;       // shown markers of streams, in an image that has them
  bool shadows_on = true;
  ShadowTechnique shadow_technique;
  bool is_path_traced = false;  // colours come from the path tracer
  bool ray_effects = false;     // of the settings, on a device that traces them
  bool has_lights = false;
  bool needs_shadow_maps = false;  // the technique, for this scene
  bool bloom = false;              // of the post settings
  bool metered = false;            // exposure, of the post settings
  bool depth_of_field = false;     // a lens of the post settings or of a camera, and the device can blur
  bool has_optics = false;         // of the post settings
  bool has_mask = false;           // content mask of the optics, on an image without distortion
};

struct FramePlan {
  // Geometry.
  bool visibility_buffer = false;  // ids and depths of the cameras
  CameraLevels camera_levels = CameraLevels::finest;
  bool shadow_maps = false;
  bool shadow_map_levels_of_detail = false;
  // Shadows.
  bool shadows = false;
  bool acceleration_structures = false;
  bool shadow_mask = false;  // one bit per light and pixel, from maps and rays
  // Colours.
  bool shading = false;          // false: colours are not requested, or a debug view replaces them
  bool coverage_merge = false;   // one shading sample for the triangles of one surface in a pixel
  bool compute_shading = false;  // from the visibility buffer
  bool ray_effects = false;      // before compute shading, which reads them
  bool hdr_samples = false;      // compute shading writes the HDR target, which the tone-map pass reads
  bool forward = false;          // the whole scene, or forward-only draws over compute shading
  bool markers = false;          // over all surfaces
  bool tone_map = false;         // of the HDR target; otherwise compute shading has tone-mapped its pixels
  bool linear = false;           // the tone-map pass averages the samples for the linear plane
  bool path_resolve = false;     // colours from path-traced sums, instead of shading
  bool depth_of_field = false;   // blurs the HDR samples of a camera with a lens
  bool metering = false;         // exposure from HDR samples or path-traced sums
  bool bloom = false;            // blurred light, from HDR samples or path-traced sums
  bool sensor = false;           // optics and sensor of the camera, instead of tone mapping
  bool mask_planes = false;      // empties planes beyond the content mask
  bool fxaa_only = false;        // FXAA on the pixels that compute shading has tone-mapped
  // Other outputs.
  bool surface_planes = false;
  bool inspection = false;  // debug view, picking, outline
};

// views: number of views of the image. inspection: without unavailable parts.
FramePlan plan_frame(const FrameFacts& facts, const ImageOutputs& outputs, const Inspection& inspection,
                     uint32_t views = 1);

}  // namespace fire3dv::passes

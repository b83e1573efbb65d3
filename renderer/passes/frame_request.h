// Request of an image, and its preparation.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "protocol/wire/image_outputs.h"
#include "renderer/gpu/device/vk.h"
#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/outputs/camera_history.h"

namespace fire3dv::passes {

using wire::ImageOutput;
using wire::ImageOutputs;

// Scene state of an image. Later images of a frame reuse its edits, transforms and deformation.
enum class SceneUpdate : uint8_t { update, reuse };

// Image that a caller wants to record.
struct FrameRequest {
  VkExtent2D extent{};  // of a view
  // Views that are taken together. Image and planes stack them vertically, in order. Several views share one
  // set of shadow maps.
  uint32_t views = 1;
  ImageOutputs outputs = {};
  Inspection inspection = {};  // for a single view with colours; unavailable parts are ignored
  SceneUpdate scene = SceneUpdate::update;
  bool markers = false;  // shows those of set_markers(); images of several views have none
  // Flow from the earlier image of this history to this one, which has motion and occlusion: see
  // SceneRenderer::flow(). Of a single view. Null: none.
  std::shared_ptr<const CameraHistory> flow_from = nullptr;
  bool keeps_surfaces = false;   // in the history of a single view, for flow to a later image
  bool has_history = true;       // motion and occlusion of later images compare themselves with this one
  ReplacedMemory replaced = {};  // what record() replaces in the histories; their limits leave it out
  // The view has a lens, which may be new since set_scene(). begin_next() sees it by itself; images of
  // several views have none.
  bool lens = false;
  // Of a camera with distortion: optics and sensor follow it, see SceneRenderer::develop(). image() has no
  // colours of such an image with optics, and planes no content mask.
  bool distorts = false;
  // The view or the scene moves, and another image follows at rest: see SceneRenderer::reduces_motion().
  bool in_motion = false;
  // Paths: trace_paths() goes on with the last such image while it stays the same; see there.
  bool refines = false;
  bool shows_previous_image =
      false;  // with refines: the image before it is shown until the first sample is whole
};

// Resource that prepare() could not provide.
enum class Shortage : uint8_t {
  none,
  unsupported_outputs,
  too_many_views,
  motion_snapshots,  // camera histories reference too many transform snapshots, or too many depths
  device_memory,
};

// Request with its resources. Valid for one record(), before the next prepare() or set_scene().
class PreparedFrame {
 public:
  const FrameRequest& request() const { return request_; }

 private:
  friend class SceneRenderer;
  PreparedFrame(FrameRequest request, uint64_t number) : request_(std::move(request)), number_(number) {}
  FrameRequest request_;
  uint64_t number_;
};

}  // namespace fire3dv::passes

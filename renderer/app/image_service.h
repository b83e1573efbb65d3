// Images for simulators that asked for them: what is due is drawn, and goes back over the link that it was
// asked over, with the frame that it shows.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "renderer/app/asked_camera.h"
#include "renderer/app/asked_image.h"
#include "renderer/app/live_scene.h"
#include "renderer/app/stream_intake.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/lens_pass.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::app {

// What this renderer makes of what can be asked for.
state::ImageAbilities image_abilities(const passes::SceneRenderer& renderer);

class ImageService {
 public:
  // All is borrowed.
  ImageService(gpu::Device& device, passes::SceneRenderer& renderer, const state::PoseState& poses,
               StreamIntake& intake, const LiveScene& scene)
      : device_(device),
        renderer_(renderer),
        poses_(poses),
        intake_(intake),
        scene_(scene),
        readback_(device),
        lens_(device) {}

  // Draws what is due of what is shown now, as much as possible in one submission. Returns true when there
  // was any; the renderer then has the size of the last one.
  bool draw_due(gpu::FrameRing& frames);

  // Sends what is finished.
  void deliver();
  bool in_flight() const { return readback_.in_flight() != 0; }

 private:
  struct Asked {
    state::ImageBook::Due due;
    AskedCamera camera;
  };
  struct Image {
    state::ImageBook::Asker asker = 0;
    uint32_t bits = 0;
    wire::ImageFrame frame;
  };
  struct Tag {
    TakenViews taken;
    std::vector<Image> images;  // one for each view
  };
  using Boxes = std::shared_ptr<const std::vector<passes::Box3d>>;

  std::vector<Asked> resolve(std::vector<state::ImageBook::Due>&& due);
  size_t how_many_together(std::span<const Asked> alike) const;
  bool make_room(std::span<const Asked> together);
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, std::span<const Asked> together,
              const Boxes& boxes, passes::OfFrame of_frame);
  void read_back(gpu::Recorder& recorder, const passes::ImageOutputs& outputs, Tag&& tag);
  void read_back_through_lens(gpu::Recorder& recorder, gpu::UploadBelt& belt, const AskedCamera& camera,
                              const passes::ImageOutputs& outputs, Tag&& tag);
  std::vector<passes::CameraHistory> take_histories(std::span<const Asked> together);
  void keep_histories(std::span<const Asked> together, std::vector<passes::CameraHistory>&& histories);

  gpu::Device& device_;
  passes::SceneRenderer& renderer_;
  const state::PoseState& poses_;
  StreamIntake& intake_;
  const LiveScene& scene_;
  passes::ReadbackBelt<Tag> readback_;
  passes::LensPass lens_;
  // Of open requests that want motion, by asker and id.
  std::map<std::pair<state::ImageBook::Asker, uint64_t>, passes::CameraHistory> histories_;
};

}  // namespace fire3dv::app

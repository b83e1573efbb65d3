// Draws images that simulators have asked for, on one device, and brings their pixels back to memory. Knows
// no links. One thread at a time.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/asked_camera.h"
#include "renderer/app/asked_image.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/lens_pass.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/state/image_book.h"

namespace fire3dv::app {

// What this renderer makes of what can be asked for.
state::ImageAbilities image_abilities(const passes::SceneRenderer& renderer);

class ImageMaker {
 public:
  // Both are borrowed.
  ImageMaker(gpu::Device& device, passes::SceneRenderer& renderer)
      : device_(device), renderer_(renderer), readback_(device), lens_(device) {}

  struct Asked {
    state::ImageBook::Due due;
    AskedCamera camera;
  };
  // Where everything is, and the boxes of all instances, if anybody wants boxes.
  struct Moment {
    const state::PoseState& poses;
    std::shared_ptr<const std::vector<passes::Box3d>> boxes;
  };

  // The images that follow show other poses than those before.
  void begin_moment() { of_frame_ = passes::OfFrame::first; }
  // Images to draw, alike ones side by side, instead of all earlier ones.
  void begin(std::vector<Asked>&& asked);
  bool has_work() const { return next_ < asked_.size(); }
  // Those that are drawn or refused.
  std::span<const Asked> processed() const { return std::span(asked_).first(next_); }

  // Draws some of them in one submission, whose read-back ends with the image that reaches most_bytes.
  // Returns false when nothing was submitted.
  bool draw(gpu::FrameRing& frames, const Moment& moment, uint64_t most_bytes = kMostSubmittedBytes);
  // Limit of one submission: its images are kept in host memory until they are sent.
  static constexpr uint64_t kMostSubmittedBytes = uint64_t{64} << 20;
  // Cost of the images drawn since the last call.
  uint64_t take_cost() { return std::exchange(cost_, 0); }

  // None of what was given and is not drawn yet will be.
  void refuse_rest(const std::string& why);

  // Drawn but not handed over.
  size_t in_flight() const { return readback_.in_flight(); }
  // Hands over what is finished.
  using Take =
      std::function<void(state::ImageBook::Asker asker, const wire::ImageFrame&, const AskedImage& pixels)>;
  void deliver(const Take& take);

  // What the device has no memory for, since the last call.
  struct Refused {
    state::ImageBook::Due due;
    wire::ImageRefusal reason;
    std::string why;
  };
  std::vector<Refused> take_refused() { return std::exchange(refused_, {}); }

  // What is kept for other requests than these goes. By asker and id, in their order.
  using Key = std::pair<state::ImageBook::Asker, uint64_t>;
  void keep_only(std::span<const Key> open);
  // Another scene is drawn.
  void forget_histories() { histories_.clear(); }

 private:
  struct Image {
    state::ImageBook::Asker asker = 0;
    uint32_t bits = 0;
    wire::ImageFrame frame;
  };
  struct Tag {
    TakenViews taken;
    std::vector<Image> images;  // one for each view
  };

  size_t how_many_together(std::span<const Asked> rest, uint64_t most_bytes) const;
  bool make_room(std::span<const Asked> together);
  void refuse(std::span<const Asked> together, wire::ImageRefusal reason, const std::string& why);
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, std::span<const Asked> together,
              const Moment& moment);
  void read_back(gpu::Recorder& recorder, const passes::ImageOutputs& outputs, Tag&& tag);
  void read_back_through_lens(gpu::Recorder& recorder, gpu::UploadBelt& belt, const AskedCamera& camera,
                              const passes::ImageOutputs& outputs, Tag&& tag);
  std::vector<passes::CameraHistory> take_histories(std::span<const Asked> together);
  void keep_histories(std::span<const Asked> together, std::vector<passes::CameraHistory>&& histories);

  gpu::Device& device_;
  passes::SceneRenderer& renderer_;
  passes::ReadbackBelt<Tag> readback_;
  passes::LensPass lens_;
  std::vector<Asked> asked_;
  size_t next_ = 0;  // of them, that is not drawn yet
  uint64_t cost_ = 0;
  passes::OfFrame of_frame_ = passes::OfFrame::first;
  std::vector<Refused> refused_;
  std::map<Key, passes::CameraHistory> histories_;  // of open requests that want motion
};

}  // namespace fire3dv::app

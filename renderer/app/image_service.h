// Images for simulators that asked for them: what is due is dealt out to the devices, drawn, and goes back
// over the link that it was asked over, with the frame that it shows.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "renderer/app/further_devices.h"
#include "renderer/app/image_maker.h"
#include "renderer/app/live_scene.h"
#include "renderer/app/stream_intake.h"

namespace fire3dv::app {

class ImageService {
 public:
  // All is borrowed, and of the first device.
  ImageService(gpu::Device& device, passes::SceneRenderer& renderer, const state::PoseState& poses,
               StreamIntake& intake, const LiveScene& scene)
      : device_(device), poses_(poses), intake_(intake), scene_(scene), first_(device, renderer) {}

  // Borrowed. settings: how the first one draws, at any time.
  void spread_over(FurtherDevices& further, const passes::DrawSettings& settings) {
    further_ = &further;
    settings_ = &settings;
  }

  // Draws what is due of what is shown now, as much as possible in one submission on each device. Returns
  // true when there was any; the first device's renderer then has the size of the last one.
  bool draw_due(gpu::FrameRing& frames);

  // Sends what is finished.
  void deliver();
  bool in_flight() const;

  // What has been submitted on all devices.
  using Mark = std::vector<uint64_t>;  // timeline values
  Mark submitted() const;
  bool is_done(const Mark& mark) const;
  void wait(const Mark& mark) const;

 private:
  using Key = ImageMaker::Key;
  struct Place {
    size_t device = 0;
    uint64_t pixels = 0;
  };

  std::vector<ImageMaker::Asked> resolve(std::vector<state::ImageBook::Due>&& due);
  void deal_out(std::vector<ImageMaker::Asked>&& asked);
  size_t place_of(const ImageMaker::Asked& asked);
  void draw_on_all(gpu::FrameRing& frames, const ImageMaker::Moment& moment);
  void forget_what_is_over();
  void refuse_what_had_no_room(ImageMaker& maker);
  size_t device_count() const { return 1 + further().size(); }
  std::span<const std::unique_ptr<FurtherDevice>> further() const;
  const gpu::Device& device_at(size_t index) const;
  ImageMaker& maker_at(size_t index);

  gpu::Device& device_;
  const state::PoseState& poses_;
  StreamIntake& intake_;
  const LiveScene& scene_;
  ImageMaker first_;
  FurtherDevices* further_ = nullptr;
  const passes::DrawSettings* settings_ = nullptr;
  // A request stays with its device, so that its images come in their order.
  std::map<Key, Place> places_;
  std::vector<uint64_t> pixels_of_device_;
  size_t last_place_ = 0;
};

}  // namespace fire3dv::app

// Requested images: draws what is due in fair turns of the streams, on one or several devices, and sends each
// image over the link of its request, with the frame that it shows.
#pragma once

#include <deque>
#include <functional>
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
  struct Rules {
    int64_t slice_ns = TimeSlices{}.image_ns;  // of one call of draw_due()
    bool lockstep = false;                     // no stream waits so that others have their turns
    std::function<bool()> is_stop_requested = [] { return false; };
  };
  // All is borrowed, and of the first device.
  ImageService(gpu::Device& device, passes::SceneRenderer& renderer, const state::PoseState& poses,
               StreamIntake& intake, const LiveScene& scene, Rules rules)
      : device_(device),
        poses_(poses),
        intake_(intake),
        scene_(scene),
        rules_(std::move(rules)),
        first_(device, renderer),
        turns_(rules_.slice_ns, !rules_.lockstep) {}

  // Borrowed. settings: how the first one draws, at any time.
  void spread_over(FurtherDevices& further, const passes::DrawSettings& settings) {
    further_ = &further;
    settings_ = &settings;
  }

  struct Drawn {
    bool any = false;       // the first device's renderer has the size of the last image
    bool has_more = false;  // images that are due were left for the next call
  };
  // Draws images that are due of the frames shown now, stream after stream in fair order, until a time slice
  // is over. Waits for submissions no longer than that, unless one that was taken for short is not.
  Drawn draw_due(gpu::FrameRing& frames);

  // Sends what is finished.
  void deliver();
  bool in_flight() const;

  // What has been submitted on all devices.
  using Mark = std::vector<uint64_t>;  // timeline values
  Mark submitted() const;
  bool is_done(const Mark& mark) const;
  void wait(const Mark& mark) const;
  bool wait_for(const Mark& mark, int64_t timeout_ns) const;  // true when it is done

 private:
  using Key = ImageMaker::Key;
  struct Place {
    size_t device = 0;
    uint64_t pixels = 0;
  };

  struct Flight {
    Mark mark;
    state::ImageBook::Asker asker = 0;
    int64_t submitted_ns = 0;
  };

  bool draw_turn(gpu::FrameRing& frames, state::ImageBook::Asker asker, ImageMaker::Moment& moment,
                 int64_t end_ns);
  void note_finished();
  bool has_room(int64_t end_ns);
  std::vector<ImageMaker::Asked> resolve(std::vector<state::ImageBook::Due>&& due);
  void deal_out(std::vector<ImageMaker::Asked>&& asked);
  size_t place_of(const ImageMaker::Asked& asked);
  void draw_round(gpu::FrameRing& frames, const ImageMaker::Moment& moment, uint64_t most_bytes);
  bool has_work();
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
  const Rules rules_;
  ImageMaker first_;
  FurtherDevices* further_ = nullptr;
  const passes::DrawSettings* settings_ = nullptr;
  // A request stays with its device, so that its images come in their order.
  std::map<Key, Place> places_;
  std::vector<uint64_t> pixels_of_device_;
  size_t last_place_ = 0;
  state::ImageTurns turns_;
  std::deque<Flight> flights_;  // submissions that are not done, as turns_ has them
  int64_t last_done_ns_ = 0;
};

}  // namespace fire3dv::app

// Service of image requests: renders the due images of an ImageRequestQueue in fair turns of the streams, on
// one or several devices. Each image is tagged with the displayed frame and sent back over the queue.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "renderer/images/image_batch_renderer.h"
#include "renderer/images/secondary_devices.h"
#include "renderer/images/world_batches.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/live_scene/peer_draw_time.h"
#include "renderer/state/image_scheduler.h"
#include "renderer/streams/image_request_queue.h"

namespace fire3dv::app {

class ImageService {
 public:
  struct Rules {
    int64_t slice_ns = TimeSlices{}.image_ns;  // per call of draw_due()
    bool lockstep = false;                     // turns without time slices
    std::function<bool()> is_stop_requested = [] { return false; };
  };
  // Borrows all arguments, which belong to the primary device.
  ImageService(gpu::Device& device, passes::SceneRenderer& renderer, const state::PoseState& poses,
               ImageRequestQueue& requests, LiveScene& scene, Rules rules)
      : device_(device),
        poses_(poses),
        requests_(requests),
        scene_(scene),
        rules_(std::move(rules)),
        renderer_(renderer),
        first_(device, renderer),
        batches_(device),
        scheduler_(rules_.slice_ns, !rules_.lockstep) {}

  // Borrowed. settings: current settings of the primary device.
  void use_secondary_devices(SecondaryDevices& devices, const settings::DrawSettings& settings) {
    secondary_ = &devices;
    settings_ = &settings;
  }

  // Borrowed: measures and limits the drawing time of peers' content on the primary device.
  void use_draw_time(PeerDrawTime& draw_time) { draw_time_ = &draw_time; }

  struct Drawn {
    bool any = false;       // the primary renderer has the size of the last requested image
    bool has_more = false;  // due images remain for the next call
  };
  // Renders due images of the current frames, in fair order of streams, for at most one time slice. Waits for
  // submissions no longer, unless the estimate of a submission was too short.
  Drawn draw_due(gpu::FrameRing& frames);

  // True while the paths of an image are traced: the scene must stay until then, poses may change.
  bool is_tracing() const { return first_.is_tracing(); }

  // Ends submissions in flight of whose images no request is open any more. draw_due() does so, too.
  void end_withdrawn(gpu::FrameRing& frames);

  // Sends finished images.
  void deliver();
  bool in_flight() const;
  size_t open_requests() const { return requests_.count(); }

  // Submissions of all devices so far.
  using Mark = std::vector<uint64_t>;  // timeline values
  Mark submitted() const;
  bool is_done(const Mark& mark) const;
  void wait(const Mark& mark) const;
  bool wait_for(const Mark& mark, int64_t timeout_ns) const;  // true when done

 private:
  using Key = ImageBatchRenderer::Key;
  struct Assignment {
    size_t device = 0;
    uint64_t pixels = 0;
  };

  struct Submission {
    Mark mark;
    int64_t begun_ns = 0;  // its preparation on the host
    bool compiles = false;
    // Of the first device; empty: it drew none, or images that cannot be withdrawn.
    std::vector<state::ImageRequestRegistry::Due> images = {};
  };

  Drawn go_on_tracing(gpu::FrameRing& frames);
  bool do_others_wait(const state::ImageRequestRegistry::Due& traced, int64_t now_ns);
  void report_samples();
  bool draw_batches(gpu::FrameRing& frames, const std::vector<state::ImageRequestRegistry::Due>& due,
                    int64_t end_ns);
  void begin_batch(const state::ImageRequestRegistry::Due& due);
  bool go_on_with_batch(gpu::FrameRing& frames, int64_t end_ns);
  bool draw_turn(gpu::FrameRing& frames, state::RequesterId requester, ImageBatchRenderer::Moment& moment,
                 int64_t end_ns);
  void limit(gpu::FrameRing& frames, bool has_view);
  void redraw_or_refuse(const state::ImageRequestRegistry::Due& due);
  void refuse_incomplete(std::vector<ImageBatchRenderer::WorkItem>& work);
  void record_finished();
  bool takes_new_pipelines();
  bool has_room(int64_t end_ns);
  std::vector<ImageBatchRenderer::WorkItem> resolve(std::vector<state::ImageRequestRegistry::Due>&& due);
  void distribute(std::vector<ImageBatchRenderer::WorkItem>&& work);
  size_t assign_device(const ImageBatchRenderer::WorkItem& work);
  void draw_round(gpu::FrameRing& frames, const ImageBatchRenderer::Moment& moment,
                  const ImageBatchRenderer::Limits& limits);
  bool has_work();
  uint64_t largest_next_cost();  // of all devices
  void drop_closed_requests();
  void forward_refusals(ImageBatchRenderer& batch_renderer);
  size_t device_count() const { return 1 + secondary().size(); }
  std::span<const std::unique_ptr<SecondaryDevice>> secondary() const;
  const gpu::Device& device_at(size_t index) const;
  ImageBatchRenderer& renderer_at(size_t index);

  gpu::Device& device_;
  const state::PoseState& poses_;
  ImageRequestQueue& requests_;
  LiveScene& scene_;
  const Rules rules_;
  const passes::SceneRenderer& renderer_;  // of the first device
  ImageBatchRenderer first_;
  WorldBatches batches_;
  SecondaryDevices* secondary_ = nullptr;
  PeerDrawTime* draw_time_ = nullptr;
  const settings::DrawSettings* settings_ = nullptr;
  // A request keeps its device, so that its images stay in order.
  std::map<Key, Assignment> assignments_;
  std::vector<uint64_t> pixels_of_device_;
  size_t last_device_ = 0;
  state::ImageScheduler scheduler_;
  std::deque<Submission> submissions_;  // unfinished submissions, in the order of scheduler_
  std::vector<Key> limited_;            // images in flight that have time limits of their own
  int64_t last_done_ns_ = 0;
  uint64_t pipelines_ = 0;    // gpu::pipelines_begun() of the last submission
  uint64_t closed_seen_ = 0;  // ImageRequestQueue::closed() of the last drop_closed_requests()
};

}  // namespace fire3dv::app

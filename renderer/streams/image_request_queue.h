// Image requests of streams: interfaces between the stream receiver, which routes messages, and the queue of
// requests. Calls go one way each: the receiver hands requests to an ImageRequestHandler while it polls; the
// handler replies over ImageReplies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/wire/image.h"
#include "renderer/scene/model/ground.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/image_request_registry.h"
#include "renderer/state/image_scheduler.h"

namespace fire3dv::app {

class ImageRequestHandler {
 public:
  virtual ~ImageRequestHandler() = default;
  // A stream requests images of its current run, or cancels a request, over a link that carries images.
  // budget: of its peer.
  virtual void on_image_request(state::RequesterId requester, const wire::ImageRequest& request,
                                const std::shared_ptr<PeerBudget>& budget) = 0;
  // The run has ended: its requests are void.
  virtual void on_requester_ended(state::RequesterId requester) = 0;
  // True if an image of the stream is due or being drawn, so that the stream may wait for it.
  virtual bool owes_image(state::RequesterId requester, int64_t now_ns) const = 0;
};

// All functions accept requesters that have ended.
class ImageReplies {
 public:
  virtual ~ImageReplies() = default;
  // Appearance that no request names: that of the renderer's own images, for viewers of the live view.
  struct Appearance {
    std::optional<scene::Ground> ground;
    float exposure = 0;    // of the camera; 0: as in the settings
    scene::ThinLens lens;  // of the camera
    bool markers = false;  // on the first device
    // Samples of the path-traced image that the viewer has: the next one goes on from there and comes after a
    // short time. nullopt: it comes when it is whole.
    std::optional<uint32_t> shown_samples = std::nullopt;
    bool keeps_samples = false;  // the path-traced image goes on after those of others
    bool in_motion = false;      // an image at rest follows; see passes::FrameRequest
  };
  struct Shown {
    state::ImageRequestRegistry::Shown frame;
    wire::Affine3x4d world_from_stream;
    Appearance appearance = {};
  };
  virtual std::optional<Shown> shown(state::RequesterId requester) const = 0;  // nullopt: it has ended
  // Description of the requesting stream; nullopt: it has ended, or is a viewer.
  virtual std::optional<wire::StreamDescription> description(state::RequesterId) const { return {}; }
  // Sends a refusal. is_logged: also logs it.
  virtual void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused,
                            bool is_logged) = 0;
  // Returns false if the image is lost, since the peer is too slow or disconnected.
  virtual bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                          const transport::ListenerLink::FillPixels& fill) = 0;
  // The requested image has so many path-traced samples now.
  virtual void set_samples(state::RequesterId, uint64_t /*request*/, uint32_t /*samples*/) {}
};

// Queue of image requests of all streams: registers them, lists those that are due, and replies to their
// streams. It has neither a device nor links. Single-threaded.
class ImageRequestQueue final : public ImageRequestHandler {
 public:
  using Due = state::ImageRequestRegistry::Due;
  // Borrows `replies`.
  ImageRequestQueue(ImageReplies& replies, const state::ImageAbilities& abilities)
      : replies_(replies), registry_(abilities) {}

  // Another renderer with other abilities takes over. Precondition: no request is open.
  void set_abilities(const state::ImageAbilities& abilities) {
    registry_ = state::ImageRequestRegistry(abilities);
  }

  void on_image_request(state::RequesterId requester, const wire::ImageRequest& request,
                        const std::shared_ptr<PeerBudget>& budget) override;
  void on_requester_ended(state::RequesterId requester) override {
    registry_.remove_all(requester);
    progress_.erase(requester);
  }
  bool owes_image(state::RequesterId requester, int64_t now_ns) const override;

  // Streams with due images of the current frames. Refuses requests that can no longer be met.
  std::vector<state::ImageDemand> demands(int64_t now_ns);
  // Due images of one stream; they stay due until mark_rendered().
  std::vector<Due> due(state::RequesterId requester, int64_t now_ns) const;
  Result<void> check_memory(const Due& due, uint64_t bytes) const {
    return registry_.check_memory(due, bytes);
  }
  std::shared_ptr<PeerBudget> budget(const Due& due) const { return registry_.budget(due); }
  std::optional<wire::StreamDescription> description(state::RequesterId requester) const {
    return replies_.description(requester);
  }
  uint64_t cost(const wire::ImageRequest& request) const { return registry_.cost(request); }
  void mark_rendered(const Due& due) {
    registry_.mark_rendered(due);
    progress_[due.requester].drawn = due.sequence;
  }
  void mark_undrawn(const Due& due) { registry_.mark_undrawn(due); }
  // Closes the request of this image.
  void refuse(const Due& due, wire::ImageRefusal reason, const std::string& why);
  // See ImageReplies.
  bool send(state::RequesterId requester, const wire::ImageFrame& frame,
            const transport::ListenerLink::FillPixels& fill) {
    progress_[requester].answered = frame.sequence;
    return replies_.send_image(requester, frame, fill);
  }
  // False once the request was withdrawn, replaced or answered, or its requester has ended.
  bool is_open(const Due& due) const {
    return replies_.shown(due.requester) && registry_.is_open(due.requester, due.request.id);
  }
  bool has(state::RequesterId requester) const { return replies_.shown(requester).has_value(); }
  void set_samples(state::RequesterId requester, uint64_t request, uint32_t samples) {
    replies_.set_samples(requester, request, samples);
  }
  wire::Affine3x4d world_from_stream(state::RequesterId requester) const;
  ImageReplies::Appearance appearance(state::RequesterId requester) const;

  // Requester and id of each open request, sorted.
  std::vector<std::pair<state::RequesterId, uint64_t>> open() const { return registry_.open(); }
  size_t count() const { return registry_.count(); }
  uint64_t closed() const { return registry_.closed(); }  // rises when requests are closed

 private:
  // Newest frames of a stream whose images were submitted, and were sent or refused.
  struct Progress {
    uint64_t drawn = 0, answered = 0;
  };

  ImageReplies& replies_;
  state::ImageRequestRegistry registry_;
  std::map<state::RequesterId, Progress> progress_;
};

}  // namespace fire3dv::app

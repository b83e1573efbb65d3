// Queue of image requests of all streams: registers them, lists those that are due, and replies to their
// streams. It has neither a device nor links. Single-threaded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "renderer/app/streams/image_routing.h"
#include "renderer/state/image_requests.h"

namespace fire3dv::app {

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
  void on_requester_ended(state::RequesterId requester) override { registry_.remove_all(requester); }

  // Streams with due images of the current frames. Refuses requests that can no longer be met.
  std::vector<state::ImageDemand> demands(int64_t now_ns);
  // Due images of one stream; they stay due until mark_rendered().
  std::vector<Due> due(state::RequesterId requester, int64_t now_ns) const;
  void mark_rendered(const Due& due) { registry_.mark_rendered(due); }
  // Closes the request of this image.
  void refuse(const Due& due, wire::ImageRefusal reason, const std::string& why);
  // See ImageReplies.
  bool send(state::RequesterId requester, const wire::ImageFrame& frame,
            const transport::ListenerLink::FillPixels& fill) {
    return replies_.send_image(requester, frame, fill);
  }
  void add_render_time(state::RequesterId requester, int64_t ns) { replies_.add_render_time(requester, ns); }
  wire::Affine3x4d world_from_stream(state::RequesterId requester) const;

  // Requester and id of each open request, sorted.
  std::vector<std::pair<state::RequesterId, uint64_t>> open() const { return registry_.open(); }
  size_t count() const { return registry_.count(); }

 private:
  ImageReplies& replies_;
  state::ImageRequestRegistry registry_;
};

}  // namespace fire3dv::app

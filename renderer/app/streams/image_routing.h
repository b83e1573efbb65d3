// Interfaces between the stream receiver, which routes messages, and the queue of image requests. Calls go
// one way each: the receiver hands requests to an ImageRequestHandler while it polls; the handler replies
// over ImageReplies.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "protocol/base/peer_budget.h"
#include "protocol/transport/link.h"
#include "protocol/wire/image.h"
#include "renderer/state/image_requests.h"

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
};

// All functions accept requesters that have ended.
class ImageReplies {
 public:
  virtual ~ImageReplies() = default;
  struct Shown {
    state::ImageRequestRegistry::Shown frame;
    wire::Affine3x4d world_from_stream;
  };
  virtual std::optional<Shown> shown(state::RequesterId requester) const = 0;  // nullopt: it has ended
  // Sends a refusal. is_logged: also logs it.
  virtual void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused,
                            bool is_logged) = 0;
  // Returns false if the image is lost, since the peer is too slow or disconnected.
  virtual bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                          const transport::ListenerLink::FillPixels& fill) = 0;
  // Charges device time to the requester's peer.
  virtual void add_render_time(state::RequesterId requester, int64_t ns) = 0;
};

}  // namespace fire3dv::app

// Routing of image requests and replies between the links of streams and the handler of requests.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "protocol/transport/link.h"
#include "renderer/state/pose_state.h"
#include "renderer/streams/image_request_queue.h"

namespace fire3dv::app {

class ImageRouter final : public ImageReplies {
 public:
  // A stream that may request images. Its link is borrowed.
  struct Requester {
    transport::ListenerLink* listener = nullptr;
    transport::PeerId peer = 0;
    state::StreamId stream = 0;
    uint64_t epoch = 0;
    std::string name;
  };

  // Borrows the poses. log: called with warnings.
  ImageRouter(const state::PoseState& poses, std::function<void(std::string)> log)
      : poses_(poses), log_(std::move(log)) {}

  // Borrowed; null (default): image requests are refused.
  void set_handler(ImageRequestHandler* handler) { handler_ = handler; }
  // Number of refusals.
  uint64_t refused() const { return refused_; }
  // A simulator that waits for an image sends no frame meanwhile.
  bool owes_image(state::RequesterId requester, int64_t now_ns) const {
    return handler_ && handler_->owes_image(requester, now_ns);
  }

  // Returns an identity that is never used again.
  state::RequesterId add(Requester requester);
  void remove(state::RequesterId requester);
  void request(state::RequesterId requester, const wire::ImageRequest& request,
               const std::shared_ptr<PeerBudget>& budget);
  void send_refusal(transport::ListenerLink& listener, transport::PeerId peer,
                    const wire::ImageRefused& refused);

  std::optional<Shown> shown(state::RequesterId requester) const override;
  std::optional<wire::StreamDescription> description(state::RequesterId requester) const override;
  void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused, bool is_logged) override;
  bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill) override;

 private:
  const Requester* find(state::RequesterId requester) const;

  const state::PoseState& poses_;
  const std::function<void(std::string)> log_;
  ImageRequestHandler* handler_ = nullptr;
  uint64_t refused_ = 0;
  std::map<state::RequesterId, Requester> requesters_;
  state::RequesterId last_ = 0;
};

}  // namespace fire3dv::app

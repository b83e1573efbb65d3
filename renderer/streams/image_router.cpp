#include "renderer/streams/image_router.h"

#include <utility>

#include "base/log.h"
#include "protocol/wire/check.h"
#include "protocol/wire/encode.h"

namespace fire3dv::app {
namespace {

constexpr size_t kMaxReplyBytes = 1024;  // limit that every link's back channel accepts

}  // namespace

state::RequesterId ImageRouter::add(Requester requester) {
  requesters_.emplace(++last_, std::move(requester));
  return last_;
}

void ImageRouter::remove(state::RequesterId requester) {
  if (handler_) handler_->on_requester_ended(requester);
  requesters_.erase(requester);
}

void ImageRouter::send_refusal(transport::ListenerLink& listener, transport::PeerId peer,
                               const wire::ImageRefused& refused) {
  wire::ImageRefused reply = refused;
  reply.message = wire::printable(refused.message, kMaxReplyBytes);
  ++refused_;
  listener.send(peer, wire::encode(reply));
}

void ImageRouter::request(state::RequesterId requester, const wire::ImageRequest& request,
                          const std::shared_ptr<PeerBudget>& budget) {
  const Requester& from = requesters_.at(requester);
  if (request.epoch != from.epoch) return;  // request of an earlier run, which has ended
  if (handler_ && from.listener->carries_images())
    return handler_->on_image_request(requester, request, budget);
  if (request.when == wire::ImageWhen::never) return;
  const std::string why = handler_
                              ? "images do not travel over " + from.listener->uri() + "; use shm:// or tcp://"
                              : std::string("this program makes no images for others");
  send_refusal(*from.listener, from.peer, {request.epoch, request.id, wire::ImageRefusal::no_way_back, why});
}

const ImageRouter::Requester* ImageRouter::find(state::RequesterId requester) const {
  const auto found = requesters_.find(requester);
  return found == requesters_.end() ? nullptr : &found->second;
}

std::optional<ImageReplies::Shown> ImageRouter::shown(state::RequesterId requester) const {
  const Requester* const from = find(requester);
  if (!from) return {};
  const state::Stream& stream = poses_.streams()[from->stream];
  return Shown{{from->epoch, stream.header.sequence, stream.header.sim_time_ns}, stream.world_from_stream};
}

std::optional<wire::StreamDescription> ImageRouter::description(state::RequesterId requester) const {
  const Requester* const from = find(requester);
  if (!from) return {};
  return poses_.description(from->stream);
}

void ImageRouter::refuse_image(state::RequesterId requester, const wire::ImageRefused& refused,
                               bool is_logged) {
  const Requester* const from = find(requester);
  if (!from) return;
  if (is_logged)
    log_(warning("image request of stream \"" + from->name +
                 "\" refused: " + wire::printable(refused.message, kMaxReplyBytes)));
  send_refusal(*from->listener, from->peer, refused);
}

bool ImageRouter::send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                             const transport::ListenerLink::FillPixels& fill) {
  const Requester* const from = find(requester);
  return from &&
         from->listener->send_image(from->peer, frame.request, wire::encode(frame), frame.pixel_bytes, fill);
}

}  // namespace fire3dv::app

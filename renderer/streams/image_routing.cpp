// Routing of image requests and replies between the links and the queue of requests.
#include <optional>
#include <string>
#include <utility>

#include "base/log.h"
#include "protocol/wire/check.h"
#include "protocol/wire/encode.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {
namespace {

constexpr size_t kMaxReplyBytes = 1024;  // limit that every link's back channel accepts

}  // namespace

void StreamReceiver::send_refusal(Peer peer, const wire::ImageRefused& refused) {
  wire::ImageRefused reply_message = refused;
  reply_message.message = wire::printable(refused.message, kMaxReplyBytes);
  ++refused_image_requests_;
  reply(peer, wire::encode(reply_message));
}

void StreamReceiver::route_image_request(Peer peer, const wire::ImageRequest& request) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream == stream_of_peer_.end())
    return reject(peer, Refusal::before_description, "image request before a description");
  if (request.epoch != stream->second.epoch) return;  // request of an earlier run, which has ended
  if (image_handler_ && listeners_[peer.first]->carries_images())
    return image_handler_->on_image_request(stream->second.requester, request, budget_of(peer));
  if (request.when == wire::ImageWhen::never) return;
  const std::string why =
      image_handler_ ? "images do not travel over " + listeners_[peer.first]->uri() + "; use shm:// or tcp://"
                     : std::string("this program makes no images for others");
  send_refusal(peer, {request.epoch, request.id, wire::ImageRefusal::no_way_back, why});
}

const std::pair<const StreamReceiver::Peer, StreamReceiver::PeerStream>* StreamReceiver::find_requester(
    state::RequesterId requester) const {
  const auto peer = peer_of_requester_.find(requester);
  if (peer == peer_of_requester_.end()) return nullptr;
  const auto stream = stream_of_peer_.find(peer->second);
  return stream == stream_of_peer_.end() ? nullptr : &*stream;
}

std::optional<ImageReplies::Shown> StreamReceiver::shown(state::RequesterId requester) const {
  const auto* entry = find_requester(requester);
  if (!entry) return {};
  const state::Stream& stream = poses_.streams()[entry->second.id];
  return Shown{{entry->second.epoch, stream.header.sequence, stream.header.sim_time_ns},
               stream.world_from_stream};
}

void StreamReceiver::refuse_image(state::RequesterId requester, const wire::ImageRefused& refused,
                                  bool is_logged) {
  const auto* entry = find_requester(requester);
  if (!entry) return;
  if (is_logged)
    log(warning("image request of stream \"" + entry->second.name +
                "\" refused: " + wire::printable(refused.message, kMaxReplyBytes)));
  send_refusal(entry->first, refused);
}

bool StreamReceiver::send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                                const transport::ListenerLink::FillPixels& fill) {
  const auto* entry = find_requester(requester);
  if (!entry) return false;
  const auto& [listener, peer] = entry->first;
  return listeners_[listener]->send_image(peer, frame.request, wire::encode(frame), frame.pixel_bytes, fill);
}

}  // namespace fire3dv::app

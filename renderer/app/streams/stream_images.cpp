// Image requests of the stream receiver: receives requests, returns refusals and images over the same link.
#include "protocol/wire/check.h"
#include "renderer/app/streams/stream_receiver.h"

namespace fire3dv::app {
namespace {

constexpr size_t kMostAnswerBytes = 1024;  // limit that every link's back channel accepts

}  // namespace

void StreamReceiver::send_refusal(Peer peer, const wire::ImageRefused& refused) {
  wire::ImageRefused answer = refused;
  answer.message = wire::printable(refused.message, kMostAnswerBytes);
  ++refused_image_requests_;
  reply(peer, wire::encode(answer));
}

void StreamReceiver::ask_for_image(Peer peer, const wire::ImageRequest& request) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream == stream_of_peer_.end())
    return reject(peer, Refusal::before_description, "image request before a description");
  if (request.epoch != stream->second.epoch) return;  // request of an earlier run, which has ended
  if (!images_ || !listeners_[peer.first]->carries_images()) {
    if (request.when == wire::ImageWhen::never) return;
    const std::string why =
        images_ ? "images do not travel over " + listeners_[peer.first]->uri() + "; use shm:// or tcp://"
                : std::string("this program makes no images for others");
    return send_refusal(peer, {request.epoch, request.id, wire::ImageRefusal::no_way_back, why});
  }
  const std::shared_ptr<PeerBudget> budget = budget_of(peer);
  const auto refused = images_->ask(stream->second.asker, request, budget);
  if (!refused) return;
  // Logs limit refusals once per peer and resource; metrics count all.
  const bool is_logged = !refused->over || budget->refused(*refused->over) == 1;
  if (is_logged) note("stream \"" + stream->second.name + "\" asks for an image: " + refused->answer.message);
  send_refusal(peer, refused->answer);
}

const std::pair<const StreamReceiver::Peer, StreamReceiver::PeerStream>* StreamReceiver::find_asker(
    state::ImageRequestRegistry::Asker asker) const {
  const auto peer = peer_of_asker_.find(asker);
  if (peer == peer_of_asker_.end()) return nullptr;
  const auto stream = stream_of_peer_.find(peer->second);
  return stream == stream_of_peer_.end() ? nullptr : &*stream;
}

std::optional<state::ImageRequestRegistry::Shown> StreamReceiver::shown_of(
    state::ImageRequestRegistry::Asker asker) const {
  const auto* entry = find_asker(asker);
  if (!entry) return {};
  const wire::PoseFrameHeader& header = poses_.streams()[entry->second.id].header;
  return state::ImageRequestRegistry::Shown{entry->second.epoch, header.sequence, header.sim_time_ns};
}

std::vector<state::ImageDemand> StreamReceiver::image_demands(int64_t now_ns) {
  if (!images_) return {};
  std::vector<state::ImageRequestRegistry::Refused> refused;
  std::vector<state::ImageDemand> demands = images_->demands(
      [this](state::ImageRequestRegistry::Asker asker) { return shown_of(asker); }, now_ns, refused);
  for (const state::ImageRequestRegistry::Refused& one : refused)
    if (const auto* entry = find_asker(one.asker)) send_refusal(entry->first, one.answer);
  return demands;
}

std::vector<state::ImageRequestRegistry::Due> StreamReceiver::due_images(
    state::ImageRequestRegistry::Asker asker, int64_t now_ns) const {
  const auto shown = shown_of(asker);
  return shown ? images_->due(asker, *shown, now_ns) : std::vector<state::ImageRequestRegistry::Due>();
}

void StreamReceiver::add_render_time(state::ImageRequestRegistry::Asker asker, int64_t ns) {
  const auto* entry = find_asker(asker);
  if (!entry) return;
  if (const auto state = peers_.find(entry->first); state != peers_.end() && state->second.budget)
    state->second.budget->add_render_ns(ns);
}

void StreamReceiver::refuse_image(const state::ImageRequestRegistry::Due& due, wire::ImageRefusal reason,
                                  const std::string& why) {
  images_->drop(due.asker, due.request.id);
  const auto* entry = find_asker(due.asker);
  if (!entry) return;
  note("stream \"" + entry->second.name + "\" asks for an image: " + wire::printable(why, kMostAnswerBytes));
  send_refusal(entry->first, {due.request.epoch, due.request.id, reason, why});
}

bool StreamReceiver::send_image(state::ImageRequestRegistry::Asker asker, const wire::ImageFrame& frame,
                                const transport::ListenerLink::FillPixels& fill) {
  const auto* entry = find_asker(asker);
  if (!entry) return false;
  const auto& [listener, peer] = entry->first;
  return listeners_[listener]->send_image(peer, frame.request, wire::encode(frame), frame.pixel_bytes, fill);
}

wire::Affine3x4d StreamReceiver::world_from_stream(state::ImageRequestRegistry::Asker asker) const {
  const auto* entry = find_asker(asker);
  return entry ? poses_.streams()[entry->second.id].world_from_stream : wire::Affine3x4d{};
}

}  // namespace fire3dv::app

// What the intake does about images: requests come in, answers and images go back the same way.
#include "protocol/wire/check.h"
#include "renderer/app/stream_intake.h"

namespace fire3dv::app {
namespace {

constexpr size_t kMostAnswerBytes = 1024;  // an answer must fit what every link carries back

}  // namespace

void StreamIntake::tell_refused(Peer peer, const wire::ImageRefused& refused) {
  wire::ImageRefused answer = refused;
  answer.message = wire::printable(refused.message, kMostAnswerBytes);
  ++refused_image_requests_;
  reply(peer, wire::encode(answer));
}

void StreamIntake::ask_for_image(Peer peer, const wire::ImageRequest& request) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream == stream_of_peer_.end())
    return reject(peer, Refusal::before_description, "image request before a description");
  if (request.epoch != stream->second.epoch) return;  // of an earlier run, whose requests are over
  if (!images_ || !listeners_[peer.first]->carries_images()) {
    if (request.when == wire::ImageWhen::never) return;
    const std::string why =
        images_ ? "images do not travel over " + listeners_[peer.first]->uri() + "; use shm:// or tcp://"
                : std::string("this program makes no images for others");
    return tell_refused(peer, {request.epoch, request.id, wire::ImageRefusal::no_way_back, why});
  }
  const std::shared_ptr<PeerBudget> budget = budget_of(peer);
  const auto refused = images_->ask(stream->second.asker, request, budget);
  if (!refused) return;
  // Refusals by a limit are logged once per peer and resource; metrics count them.
  const bool is_logged = !refused->over || budget->refused(*refused->over) == 1;
  if (is_logged) note("stream \"" + stream->second.name + "\" asks for an image: " + refused->answer.message);
  tell_refused(peer, refused->answer);
}

const std::pair<const StreamIntake::Peer, StreamIntake::PeerStream>* StreamIntake::find_asker(
    state::ImageBook::Asker asker) const {
  const auto peer = peer_of_asker_.find(asker);
  if (peer == peer_of_asker_.end()) return nullptr;
  const auto stream = stream_of_peer_.find(peer->second);
  return stream == stream_of_peer_.end() ? nullptr : &*stream;
}

std::optional<state::ImageBook::Shown> StreamIntake::shown_of(state::ImageBook::Asker asker) const {
  const auto* entry = find_asker(asker);
  if (!entry) return {};
  const wire::PoseFrameHeader& header = poses_.streams()[entry->second.id].header;
  return state::ImageBook::Shown{entry->second.epoch, header.sequence, header.sim_time_ns};
}

std::vector<state::ImageDemand> StreamIntake::image_demands(int64_t now_ns) {
  if (!images_) return {};
  std::vector<state::ImageBook::Refused> refused;
  std::vector<state::ImageDemand> demands =
      images_->demands([this](state::ImageBook::Asker asker) { return shown_of(asker); }, now_ns, refused);
  for (const state::ImageBook::Refused& one : refused)
    if (const auto* entry = find_asker(one.asker)) tell_refused(entry->first, one.answer);
  return demands;
}

std::vector<state::ImageBook::Due> StreamIntake::due_images(state::ImageBook::Asker asker,
                                                            int64_t now_ns) const {
  const auto shown = shown_of(asker);
  return shown ? images_->due(asker, *shown, now_ns) : std::vector<state::ImageBook::Due>();
}

void StreamIntake::add_render_time(state::ImageBook::Asker asker, int64_t ns) {
  const auto* entry = find_asker(asker);
  if (!entry) return;
  if (const auto state = peers_.find(entry->first); state != peers_.end() && state->second.budget)
    state->second.budget->add_render_ns(ns);
}

void StreamIntake::refuse_image(const state::ImageBook::Due& due, wire::ImageRefusal reason,
                                const std::string& why) {
  images_->drop(due.asker, due.request.id);
  const auto* entry = find_asker(due.asker);
  if (!entry) return;
  note("stream \"" + entry->second.name + "\" asks for an image: " + wire::printable(why, kMostAnswerBytes));
  tell_refused(entry->first, {due.request.epoch, due.request.id, reason, why});
}

bool StreamIntake::send_image(state::ImageBook::Asker asker, const wire::ImageFrame& frame,
                              const transport::ListenerLink::FillPixels& fill) {
  const auto* entry = find_asker(asker);
  if (!entry) return false;
  const auto& [listener, peer] = entry->first;
  return listeners_[listener]->send_image(peer, frame.request, wire::encode(frame), frame.pixel_bytes, fill);
}

wire::Affine3x4d StreamIntake::world_from_stream(state::ImageBook::Asker asker) const {
  const auto* entry = find_asker(asker);
  return entry ? poses_.streams()[entry->second.id].world_from_stream : wire::Affine3x4d{};
}

}  // namespace fire3dv::app

#include "renderer/streams/image_request_queue.h"

namespace fire3dv::app {

void ImageRequestQueue::on_image_request(state::RequesterId requester, const wire::ImageRequest& request,
                                         const std::shared_ptr<PeerBudget>& budget) {
  const auto refused = registry_.add(requester, request, budget);
  if (!refused) return;
  // Refusals by a limit are logged once per peer and resource; metrics count all.
  const bool is_logged = !refused->over || budget->refused(*refused->over) == 1;
  replies_.refuse_image(requester, refused->answer, is_logged);
}

std::vector<state::ImageDemand> ImageRequestQueue::demands(int64_t now_ns) {
  std::vector<state::ImageRequestRegistry::Refused> refused;
  const auto shown = [this](state::RequesterId requester) {
    const std::optional<ImageReplies::Shown> known = replies_.shown(requester);
    return known ? std::optional(known->frame) : std::nullopt;
  };
  std::vector<state::ImageDemand> demands = registry_.demands(shown, now_ns, refused);
  for (const state::ImageRequestRegistry::Refused& each : refused)
    replies_.refuse_image(each.requester, each.answer, false);
  return demands;
}

std::vector<ImageRequestQueue::Due> ImageRequestQueue::due(state::RequesterId requester,
                                                           int64_t now_ns) const {
  const std::optional<ImageReplies::Shown> shown = replies_.shown(requester);
  return shown ? registry_.due(requester, shown->frame, now_ns) : std::vector<Due>();
}

bool ImageRequestQueue::owes_image(state::RequesterId requester, int64_t now_ns) const {
  const auto progress = progress_.find(requester);
  const bool is_drawing = progress != progress_.end() && progress->second.answered < progress->second.drawn;
  return is_drawing || !due(requester, now_ns).empty();
}

void ImageRequestQueue::refuse(const Due& due, wire::ImageRefusal reason, const std::string& why) {
  registry_.remove(due.requester, due.request.id);
  progress_[due.requester].answered = due.sequence;
  replies_.refuse_image(due.requester, {due.request.epoch, due.request.id, reason, why}, true);
}

wire::Affine3x4d ImageRequestQueue::world_from_stream(state::RequesterId requester) const {
  const std::optional<ImageReplies::Shown> shown = replies_.shown(requester);
  return shown ? shown->world_from_stream : wire::Affine3x4d{};
}

ImageReplies::Appearance ImageRequestQueue::appearance(state::RequesterId requester) const {
  const std::optional<ImageReplies::Shown> shown = replies_.shown(requester);
  return shown ? shown->appearance : ImageReplies::Appearance{};
}

}  // namespace fire3dv::app

#include "renderer/state/image_request_registry.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <tuple>

#include "base/error.h"

namespace fire3dv::state {
namespace {

std::string output_names(uint32_t outputs) {
  std::string names;
  for (uint32_t bit = 0; bit < 32; ++bit) {
    if ((outputs >> bit & 1) == 0) continue;
    if (!names.empty()) names += ", ";
    names += bit < wire::kImageOutputCount ? wire::image_output_name(bit) : "of bit " + std::to_string(bit);
  }
  return names;
}

// Outputs of batches: planes of one image each.
constexpr uint32_t kBatchOutputs =
    wire::kRequestableOutputs &
    ~uint32_t{wire::kColorLinearF16 | wire::kMotion | wire::kOcclusionU32 | wire::kBoxes2d | wire::kBoxes3d};

// Reason why a batch is not supported; empty: it is.
std::string unsupported_in_batches(const wire::ImageRequest& request) {
  if (const uint32_t outputs = request.outputs & ~kBatchOutputs; outputs != 0)
    return "the output " + output_names(outputs);
  if (request.intrinsics.lens.model != wire::LensModel::none) return "lens distortion";
  if (request.intrinsics.f_number != 0) return "depth of field";
  if (request.markers) return "markers";
  if (request.complete) return "the flag complete";
  return {};
}

uint64_t pose_bytes(const wire::ImageBatch& batch) {
  return (batch.poses.size() + batch.view_poses.size()) * sizeof(wire::Affine3x4) +
         batch.view_projections.size() * sizeof(wire::Projection) +
         (batch.world_of_view.size() + batch.node_indices.size()) * sizeof(uint32_t) + batch.active.size();
}

// Order of drawing. Images that were drawn in one turn have one last_ns; among them those of the same size
// and outputs are neighbours, so that one submission can draw them.
std::tuple<int64_t, uint32_t, uint32_t, uint32_t> order(const wire::ImageRequest& request, int64_t last_ns) {
  return {last_ns, request.intrinsics.width, request.intrinsics.height, request.outputs};
}

}  // namespace

uint64_t drawn_bytes(const wire::ImageRequest& request) {
  const uint32_t width = request.intrinsics.width, height = request.intrinsics.height * request.views();
  const wire::ImageOutputs drawn = wire::with_sources(wire::ImageOutputs(request.outputs));
  const bool keeps_depth = drawn.has(wire::kOcclusionU32) && !is_of_one_image(request);
  return wire::pixel_bytes_of(width, height, drawn.bits(), 0) +
         (keeps_depth ? wire::pixel_bytes_of(width, height, wire::kDepthF32, 0) : 0);
}

ImageEffort effort_of(const wire::ImageRequest& request, uint32_t path_samples) {
  const bool is_shaded = wire::ImageOutputs(request.outputs).shaded();
  return {.outputs = static_cast<uint32_t>(std::popcount(request.outputs)),
          .is_distorted = request.intrinsics.lens.model != wire::LensModel::none,
          .is_blurred = is_shaded && request.intrinsics.f_number != 0,
          .has_markers = request.markers,
          .path_samples = is_shaded ? path_samples : 0};
}

ImageRequestRegistry::Refused ImageRequestRegistry::refuse(RequesterId requester,
                                                           const wire::ImageRequest& request,
                                                           wire::ImageRefusal reason, std::string message) {
  ++refused_;
  return {requester, {request.epoch, request.id, reason, std::move(message)}, {}};
}

std::optional<ImageRequestRegistry::Refused> ImageRequestRegistry::charge(
    RequesterId requester, const std::shared_ptr<PeerBudget>& budget, Entry& entry) {
  const auto take = [&](Resource resource, uint64_t amount, BudgetCharge& charge) -> std::optional<Refused> {
    Result<BudgetCharge> taken = BudgetCharge::take(budget, resource, amount);
    if (taken) {
      charge = std::move(*taken);
      return {};
    }
    Refused refused = refuse(requester, entry.request, wire::ImageRefusal::too_many,
                             taken.error().message + "; cancel requests, or ask for smaller images");
    refused.over = resource;
    return refused;
  };
  if (auto refused = take(Resource::requests, 1, entry.request_charge)) return refused;
  if (entry.request.batch) {
    if (auto refused = take(Resource::pose_bytes, pose_bytes(*entry.request.batch), entry.poses_charge))
      return refused;
  }
  return take(Resource::request_bytes, entry.pixel_bytes, entry.bytes_charge);
}

std::optional<ImageRequestRegistry::Refused> ImageRequestRegistry::add(
    RequesterId requester, const wire::ImageRequest& request, const std::shared_ptr<PeerBudget>& budget) {
  changed(requester);
  std::map<uint32_t, Entry>& places = requests_[requester];
  const auto at = places.find(request.place);
  if (at != places.end() && at->second.request.id == request.id && request.when != wire::ImageWhen::never) {
    if (at->second.request == request) return {};  // links may deliver a message twice
    return refuse(requester, request, wire::ImageRefusal::bad_request,
                  "request " + std::to_string(request.id) +
                      " was made already and says something else; an id is used once");
  }
  if (at != places.end()) {
    places.erase(at);
    ++closed_;
  }
  if (request.when == wire::ImageWhen::never) return {};

  using Refusal = wire::ImageRefusal;
  if (request.when > wire::ImageWhen::batch)
    return refuse(requester, request, Refusal::not_supported,
                  "ImageRequest.when is " + std::to_string(static_cast<int>(request.when)) +
                      ", which this renderer does not know; update it");
  if (const uint32_t more = request.outputs & ~abilities_.outputs; more != 0)
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer does not make the output " + output_names(more) + "; ask for " +
                      output_names(abilities_.outputs));
  const wire::LensModel lens = request.intrinsics.lens.model;
  if (lens != wire::LensModel::none && (!abilities_.lenses || lens > wire::LensModel::fisheye))
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer does not know the lens " + std::to_string(static_cast<int>(lens)) +
                      "; ask for images without one");
  const bool is_shaded = wire::ImageOutputs(request.outputs).shaded();
  if (request.intrinsics.f_number != 0 && is_shaded && !abilities_.thin_lenses)
    return refuse(requester, request, Refusal::not_supported,
                  "this renderer draws no depth of field, which needs its visibility buffer; leave f_number "
                  "and focus_distance_m out");
  if (request.batch) {
    if (const std::string what = unsupported_in_batches(request); !what.empty())
      return refuse(requester, request, Refusal::not_supported,
                    what + " is not available in batches; request single images");
  }
  const uint64_t bytes = drawn_bytes(request);
  if (request.batch && bytes > wire::kMaxPixelBytes)
    return refuse(requester, request, Refusal::too_large,
                  std::to_string(request.views()) + " views have " + std::to_string(bytes) +
                      " bytes; at most " + std::to_string(wire::kMaxPixelBytes) +
                      " are made at once: request them in parts, or fewer outputs");
  wire::ImageRequest one_view = request;
  one_view.batch = {};
  const uint64_t view_bytes = drawn_bytes(one_view);
  if (view_bytes > abilities_.max_pixel_bytes)
    return refuse(requester, request, Refusal::too_large,
                  "an image of " + std::to_string(request.intrinsics.width) + " x " +
                      std::to_string(request.intrinsics.height) + " has " + std::to_string(view_bytes) +
                      " bytes; at most " + std::to_string(abilities_.max_pixel_bytes) +
                      " are made: ask for a smaller one, or for fewer outputs");
  uint64_t open_bytes = bytes;
  for (const auto& [place, entry] : places) open_bytes += entry.pixel_bytes;
  if (!budget && open_bytes > abilities_.max_open_bytes)
    return refuse(requester, request, Refusal::too_many,
                  "the images that this stream asks for have " + std::to_string(open_bytes) +
                      " bytes together; at most " + std::to_string(abilities_.max_open_bytes) +
                      " are made of one frame: take some back, or ask for smaller ones");
  Entry entry;
  entry.request = request;
  entry.pixel_bytes = bytes;
  entry.budget = budget;
  if (auto refused = charge(requester, budget, entry)) return refused;
  places[request.place] = std::move(entry);
  return {};
}

void ImageRequestRegistry::remove(RequesterId requester, uint64_t id) {
  const auto places = requests_.find(requester);
  if (places == requests_.end()) return;
  changed(requester);
  closed_ += std::erase_if(places->second, [&](const auto& entry) { return entry.second.request.id == id; });
}

ImageRequestRegistry::Action ImageRequestRegistry::action_now(const Entry& entry, uint64_t sequence,
                                                              int64_t now_ns) {
  const wire::ImageRequest& request = entry.request;
  if (sequence < request.sequence) return Action::wait;
  const bool is_first = entry.rendered == 0;
  switch (request.when) {
    case wire::ImageWhen::never:
      break;
    case wire::ImageWhen::once:
    case wire::ImageWhen::batch:
      return Action::render_last;
    case wire::ImageWhen::every_nth:
      return is_first || sequence - entry.last_sequence >= request.every ? Action::render : Action::wait;
    case wire::ImageWhen::rate: {
      const bool is_time = static_cast<double>(now_ns - entry.last_ns) * request.rate_hz >= 1e9;
      return is_first || (is_time && sequence > entry.last_sequence) ? Action::render : Action::wait;
    }
    case wire::ImageWhen::exactly:
      return sequence == request.sequence ? Action::render_last : Action::overtaken;
  }
  return Action::wait;
}

std::vector<ImageDemand> ImageRequestRegistry::demands(const ShownOf& shown, int64_t now_ns,
                                                       std::vector<Refused>& refused) {
  std::vector<ImageDemand> demands;
  for (auto& [requester, places] : requests_) {
    if (places.empty()) continue;
    const std::optional<Shown> now = shown(requester);
    if (!now) continue;
    const auto noted = noted_.find(requester);
    if (noted != noted_.end() && noted->second.epoch == now->epoch &&
        noted->second.sequence == now->sequence) {
      if (noted->second.demand.cost > 0) demands.push_back(noted->second.demand);
      continue;
    }
    bool depends_on_time = false;
    ImageDemand demand{requester, 0, 0};
    const Entry* first = nullptr;
    for (auto at = places.begin(); at != places.end();) {
      const wire::ImageRequest& request = at->second.request;
      const Action action =
          request.epoch == now->epoch ? action_now(at->second, now->sequence, now_ns) : Action::wait;
      if (action == Action::overtaken) {
        refused.push_back(refuse(requester, request, wire::ImageRefusal::overtaken,
                                 "frame " + std::to_string(request.sequence) +
                                     " is not shown any more; frame " + std::to_string(now->sequence) +
                                     " is: wait for images in lockstep, or ask for what is shown next"));
        at = places.erase(at);
        ++closed_;
        continue;
      }
      depends_on_time |= request.when == wire::ImageWhen::rate;
      if (action != Action::wait) {
        const uint64_t each = cost(request);
        demand.cost += each;
        if (!first || order(request, at->second.last_ns) < order(first->request, first->last_ns)) {
          first = &at->second;
          demand.first = each;
        }
      }
      ++at;
    }
    if (!depends_on_time) noted_[requester] = {now->epoch, now->sequence, demand};
    if (demand.cost > 0) demands.push_back(demand);
  }
  return demands;
}

std::vector<ImageRequestRegistry::Due> ImageRequestRegistry::due(RequesterId requester, const Shown& shown,
                                                                 int64_t now_ns) const {
  std::vector<Due> due;
  const auto places = requests_.find(requester);
  if (places == requests_.end()) return due;
  for (const auto& [place, entry] : places->second) {
    if (entry.request.epoch != shown.epoch) continue;
    const Action action = action_now(entry, shown.sequence, now_ns);
    if (action != Action::render && action != Action::render_last) continue;
    due.push_back({requester, entry.request, entry.rendered + 1, shown.sequence, shown.sim_time_ns, now_ns,
                   entry.last_ns});
  }
  std::stable_sort(due.begin(), due.end(), [](const Due& a, const Due& b) {
    return order(a.request, a.last_ns) < order(b.request, b.last_ns);
  });
  return due;
}

std::shared_ptr<PeerBudget> ImageRequestRegistry::budget(const Due& due) const {
  const auto places = requests_.find(due.requester);
  if (places == requests_.end()) return nullptr;
  const auto at = places->second.find(due.request.place);
  if (at == places->second.end() || at->second.request.id != due.request.id) return nullptr;
  return at->second.budget;
}

Result<void> ImageRequestRegistry::check_memory(const Due& due, uint64_t bytes) const {
  const auto places = requests_.find(due.requester);
  if (places == requests_.end()) return {};
  const auto at = places->second.find(due.request.place);
  if (at == places->second.end() || at->second.request.id != due.request.id) return {};
  const Result<BudgetCharge> charge = BudgetCharge::take(at->second.budget, Resource::gpu_bytes, bytes);
  return charge ? Result<void>() : charge.error();
}

void ImageRequestRegistry::mark_rendered(const Due& due) {
  const auto places = requests_.find(due.requester);
  if (places == requests_.end()) return;
  const auto at = places->second.find(due.request.place);
  if (at == places->second.end() || at->second.request.id != due.request.id) return;
  changed(due.requester);
  Entry& entry = at->second;
  if (action_now(entry, due.sequence, due.due_ns) == Action::render_last) {
    places->second.erase(at);
    ++closed_;
    return;
  }
  entry.rendered = due.number;
  entry.last_sequence = due.sequence;
  entry.last_ns = due.due_ns;
}

void ImageRequestRegistry::mark_undrawn(const Due& due) {
  const auto places = requests_.find(due.requester);
  if (places == requests_.end()) return;
  changed(due.requester);
  const wire::ImageRequest& request = due.request;
  if (!is_of_one_image(request) && !is_open(due.requester, request.id)) return;  // withdrawn meanwhile
  // A request of one image was closed. It was within the budget, which is not charged again.
  Entry& entry = places->second.try_emplace(request.place, Entry{.request = request}).first->second;
  if (entry.request.id != request.id) return;
  entry.rendered = std::min(entry.rendered, due.number - 1);
  entry.last_sequence = due.sequence - std::min<uint64_t>(due.sequence, std::max<uint64_t>(request.every, 1));
  entry.last_ns = 0;
}

std::vector<std::pair<RequesterId, uint64_t>> ImageRequestRegistry::open() const {
  std::vector<std::pair<RequesterId, uint64_t>> open;
  for (const auto& [requester, places] : requests_)
    for (const auto& [place, entry] : places) open.emplace_back(requester, entry.request.id);
  std::ranges::sort(open);
  return open;
}

bool ImageRequestRegistry::is_open(RequesterId requester, uint64_t id) const {
  const auto places = requests_.find(requester);
  return places != requests_.end() && std::ranges::any_of(places->second, [&](const auto& entry) {
           return entry.second.request.id == id;
         });
}

size_t ImageRequestRegistry::count() const {
  size_t count = 0;
  for (const auto& [requester, places] : requests_) count += places.size();
  return count;
}

}  // namespace fire3dv::state

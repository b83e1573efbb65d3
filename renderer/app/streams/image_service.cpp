#include "renderer/app/streams/image_service.h"

#include <algorithm>
#include <exception>

#include "protocol/base/clock.h"

namespace fire3dv::app {
namespace {

// The pinhole image before lens distortion is larger than the requested one.
constexpr uint64_t kMostBytesBehindLens = uint64_t{256} << 20;
// Limit of a submission while several streams request images, so that turns can end in time.
constexpr uint64_t kSharedSubmittedBytes = uint64_t{8} << 20;

bool wants_boxes(const wire::ImageRequest& request) {
  return (request.outputs & (wire::kBoxes2d | wire::kBoxes3d)) != 0;
}

uint64_t pixels_of(const passes::Intrinsics& drawn) {
  return uint64_t{drawn.image_px.x} * drawn.image_px.y;
}

std::optional<AskedCameraRefused> too_much_behind_lens(const wire::ImageRequest& request,
                                                       const RequestCamera& camera) {
  if (camera.lens.model == passes::LensModel::none) return {};
  const uint32_t outputs = bits_of(passes::behind_lens(outputs_of(request.outputs)));
  const glm::uvec2 size = camera.pinhole.image_px;
  const uint64_t bytes = wire::pixel_bytes_of(size.x, size.y, outputs, 0);
  if (bytes <= kMostBytesBehindLens) return {};
  return AskedCameraRefused{wire::ImageRefusal::too_large,
                            "what stands behind the lens has " + std::to_string(size.x) + " x " +
                                std::to_string(size.y) + " pixels and " + std::to_string(bytes) +
                                " bytes; at most " + std::to_string(kMostBytesBehindLens) +
                                " are made: ask for a smaller image, or for fewer outputs"};
}

}  // namespace

std::span<const std::unique_ptr<SecondaryDevice>> ImageService::further() const {
  return further_ ? further_->all() : std::span<const std::unique_ptr<SecondaryDevice>>();
}

const gpu::Device& ImageService::device_at(size_t index) const {
  return index == 0 ? device_ : further()[index - 1]->device();
}

RequestRenderer& ImageService::maker_at(size_t index) {
  return index == 0 ? first_ : further()[index - 1]->maker();
}

ImageService::Drawn ImageService::draw_due(gpu::FrameRing& frames) {
  note_finished();
  const int64_t begin_ns = monotonic_ns(), end_ns = begin_ns + rules_.slice_ns;
  std::vector<state::ImageDemand> demands = intake_.image_demands(begin_ns);
  turns_.note_demands(demands, begin_ns);
  if (!demands.empty() || intake_.open_image_requests() == 0) drop_closed_requests();
  // Poses are constant during this call: all turns render the same poses.
  RequestRenderer::Moment moment{poses_, nullptr};
  for (size_t device = 0; device < device_count(); ++device) maker_at(device).begin_moment();
  Drawn drawn;
  while (!demands.empty() && !rules_.is_stop_requested()) {
    if (drawn.any && monotonic_ns() >= end_ns) break;
    if (!has_room(end_ns)) break;
    const std::optional<state::ImageRequestRegistry::Asker> asker = turns_.next(demands, monotonic_ns());
    if (!asker) break;
    drawn.any = true;
    if (!draw_turn(frames, *asker, moment, end_ns)) break;
    std::erase_if(demands, [&](const state::ImageDemand& demand) { return demand.asker == *asker; });
  }
  drawn.has_more = !demands.empty();
  return drawn;
}

// Returns false if the time slice ended before all due images of the stream were rendered.
bool ImageService::draw_turn(gpu::FrameRing& frames, state::ImageRequestRegistry::Asker asker,
                             RequestRenderer::Moment& moment, int64_t end_ns) {
  const int64_t now_ns = monotonic_ns();
  std::vector<RequestRenderer::Asked> asked = resolve(intake_.due_images(asker, now_ns));
  const auto needs_boxes = [](const RequestRenderer::Asked& a) { return wants_boxes(a.due.request); };
  if (!moment.boxes && std::ranges::any_of(asked, needs_boxes))
    moment.boxes = std::make_shared<const std::vector<passes::Box3d>>(
        passes::boxes_of_instances(scene_.scene(), poses_));
  distribute(std::move(asked));
  const uint64_t most_bytes =
      turns_.is_alone(asker, now_ns) ? RequestRenderer::kMostSubmittedBytes : kSharedSubmittedBytes;
  for (bool is_first = true; has_work(); is_first = false) {
    if (!is_first && (monotonic_ns() >= end_ns || rules_.is_stop_requested() || !has_room(end_ns))) break;
    uint64_t cost = 0;
    const Mark before = submitted();
    draw_round(frames, moment, most_bytes);
    for (size_t device = 0; device < device_count(); ++device)
      cost = std::max(cost, maker_at(device).take_cost());
    if (Mark mark = submitted(); mark != before) {
      const int64_t submitted_ns = monotonic_ns();
      turns_.submitted(asker, cost, submitted_ns);
      flights_.push_back({std::move(mark), asker, submitted_ns});
    }
  }
  const bool is_whole = !has_work();
  for (size_t device = 0; device < device_count(); ++device) {
    RequestRenderer& maker = maker_at(device);
    for (const RequestRenderer::Asked& one : maker.processed()) intake_.image_made(one.due);
    maker.begin({});
  }
  return is_whole;
}

bool ImageService::has_work() {
  for (size_t device = 0; device < device_count(); ++device) {
    if (maker_at(device).has_work()) return true;
  }
  return false;
}

// Charges the device time of finished submissions to their streams.
void ImageService::note_finished() {
  while (!flights_.empty() && is_done(flights_.front().mark)) {
    const Flight& flight = flights_.front();
    const int64_t now_ns = monotonic_ns();
    const int64_t begin_ns = std::max(flight.submitted_ns, last_done_ns_);
    turns_.finished(begin_ns, now_ns);
    intake_.add_render_time(flight.asker, now_ns - begin_ns);
    last_done_ns_ = now_ns;
    flights_.pop_front();
  }
}

// Short submissions may overlap. A long submission, or one of unknown duration, is awaited, so that another
// stream's request waits for at most one of them.
bool ImageService::has_room(int64_t end_ns) {
  while (true) {
    note_finished();
    const int64_t now_ns = monotonic_ns();
    const std::optional<int64_t> remaining_ns = turns_.remaining_ns(now_ns);
    if (remaining_ns && *remaining_ns <= rules_.slice_ns / 2) return true;
    if (now_ns >= end_ns) return false;
    (void)wait_for(flights_.front().mark, end_ns - now_ns);
  }
}

void ImageService::drop_closed_requests() {
  const std::vector<Key> open = intake_.image_requests();
  for (size_t device = 0; device < device_count(); ++device) maker_at(device).retain_only(open);
  std::erase_if(places_, [&](const auto& entry) {
    const auto& [key, place] = entry;
    if (std::ranges::binary_search(open, key)) return false;
    pixels_of_device_[place.device] -= place.pixels;
    return true;
  });
}

// Resolves cameras; refuses invalid requests.
std::vector<RequestRenderer::Asked> ImageService::resolve(
    std::vector<state::ImageRequestRegistry::Due>&& due) {
  std::vector<RequestRenderer::Asked> asked;
  for (state::ImageRequestRegistry::Due& one : due) {
    auto camera = resolve_camera(one.request, intake_.world_from_stream(one.asker), poses_, scene_);
    if (const auto* possible = std::get_if<RequestCamera>(&camera)) {
      if (auto too_much = too_much_behind_lens(one.request, *possible)) camera = std::move(*too_much);
    }
    if (const auto* refused = std::get_if<AskedCameraRefused>(&camera)) {
      intake_.refuse_image(one, refused->reason, refused->why);
    } else {
      asked.push_back({std::move(one), std::get<RequestCamera>(camera)});
    }
  }
  return asked;
}

// Assigns a request to the device with the fewest pixels of open requests; round robin among equals.
size_t ImageService::place_of(const RequestRenderer::Asked& asked) {
  const size_t count = device_count();
  if (count == 1) return 0;
  pixels_of_device_.resize(count);
  const Key key{asked.due.asker, asked.due.request.id};
  if (const auto known = places_.find(key); known != places_.end()) return known->second.device;
  size_t best = (last_place_ + 1) % count;
  for (size_t turn = 2; turn <= count; ++turn) {
    const size_t device = (last_place_ + turn) % count;
    if (pixels_of_device_[device] < pixels_of_device_[best]) best = device;
  }
  const Place place{best, pixels_of(asked.camera.pinhole)};
  pixels_of_device_[best] += place.pixels;
  places_.emplace(key, place);
  last_place_ = best;
  return best;
}

void ImageService::distribute(std::vector<RequestRenderer::Asked>&& asked) {
  std::vector<std::vector<RequestRenderer::Asked>> hands(device_count());
  for (RequestRenderer::Asked& one : asked) hands[place_of(one)].push_back(std::move(one));
  for (size_t device = 0; device < hands.size(); ++device) maker_at(device).begin(std::move(hands[device]));
}

// One submission on each device with work. Finished images are sent first, so that the number of images in
// flight stays small.
void ImageService::draw_round(gpu::FrameRing& frames, const RequestRenderer::Moment& moment,
                              uint64_t most_bytes) {
  deliver();
  std::vector<SecondaryDevice*> at_work;
  for (const std::unique_ptr<SecondaryDevice>& each : further()) {
    if (!each->maker().has_work()) continue;
    each->begin_drawing(scene_, *settings_, moment, most_bytes);
    at_work.push_back(each.get());
  }
  std::exception_ptr failure;  // first error: all devices must be awaited
  const auto attempt = [&](auto&& action) {
    try {
      action();
    } catch (...) {
      failure = std::current_exception();
    }
  };
  attempt([&] { first_.draw(frames, moment, most_bytes); });
  for (SecondaryDevice* each : at_work) {
    attempt([&] {
      if (Result<void> drawn = each->finish(); !drawn) each->maker().refuse_rest(drawn.error().message);
    });
  }
  if (failure) std::rethrow_exception(failure);
  for (size_t device = 0; device < device_count(); ++device) refuse_what_had_no_room(maker_at(device));
}

void ImageService::refuse_what_had_no_room(RequestRenderer& maker) {
  for (const RequestRenderer::Refused& refused : maker.take_refused())
    intake_.refuse_image(refused.due, refused.reason, refused.why);
}

void ImageService::deliver() {
  const auto send = [&](state::ImageRequestRegistry::Asker asker, const wire::ImageFrame& frame,
                        const RequestedImage& pixels) {
    intake_.send_image(asker, frame, [&](std::span<std::byte> to) { pixels.copy_to(to); });
  };
  for (size_t device = 0; device < device_count(); ++device) maker_at(device).deliver(send);
}

bool ImageService::in_flight() const {
  return first_.in_flight() != 0 ||
         std::ranges::any_of(further(), [](const auto& each) { return each->maker().in_flight() != 0; });
}

ImageService::Mark ImageService::submitted() const {
  Mark mark;
  for (size_t device = 0; device < device_count(); ++device)
    mark.push_back(device_at(device).last_submitted());
  return mark;
}

bool ImageService::is_done(const Mark& mark) const {
  for (size_t device = 0; device < mark.size(); ++device) {
    if (device_at(device).completed() < mark[device]) return false;
  }
  return true;
}

bool ImageService::wait_for(const Mark& mark, int64_t timeout_ns) const {
  const int64_t end_ns = monotonic_ns() + timeout_ns;
  for (size_t device = 0; device < mark.size(); ++device) {
    if (!device_at(device).wait_for(mark[device], end_ns - monotonic_ns())) return false;
  }
  return true;
}

void ImageService::wait(const Mark& mark) const {
  for (size_t device = 0; device < mark.size(); ++device) device_at(device).wait(mark[device]);
}

}  // namespace fire3dv::app

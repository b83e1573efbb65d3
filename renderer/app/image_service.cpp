#include "renderer/app/image_service.h"

#include <algorithm>
#include <chrono>
#include <exception>

namespace fire3dv::app {
namespace {

// What stands behind a lens is larger than the image.
constexpr uint64_t kMostBytesBehindLens = uint64_t{256} << 20;

int64_t monotonic_now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

bool wants_boxes(const wire::ImageRequest& request) {
  return (request.outputs & (wire::kBoxes2d | wire::kBoxes3d)) != 0;
}

uint64_t pixels_of(const passes::Intrinsics& drawn) {
  return uint64_t{drawn.image_px.x} * drawn.image_px.y;
}

std::optional<AskedCameraRefused> too_much_behind_lens(const wire::ImageRequest& request,
                                                       const AskedCamera& camera) {
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

std::span<const std::unique_ptr<FurtherDevice>> ImageService::further() const {
  return further_ ? further_->all() : std::span<const std::unique_ptr<FurtherDevice>>();
}

const gpu::Device& ImageService::device_at(size_t index) const {
  return index == 0 ? device_ : further()[index - 1]->device();
}

ImageMaker& ImageService::maker_at(size_t index) {
  return index == 0 ? first_ : further()[index - 1]->maker();
}

bool ImageService::draw_due(gpu::FrameRing& frames) {
  std::vector<state::ImageBook::Due> due = intake_.take_due_images(monotonic_now_ns());
  if (!due.empty() || intake_.open_image_requests() == 0) forget_what_is_over();
  if (due.empty()) return false;
  std::vector<ImageMaker::Asked> asked = resolve(std::move(due));
  ImageMaker::Moment moment{poses_, nullptr};
  if (std::ranges::any_of(asked, [](const ImageMaker::Asked& a) { return wants_boxes(a.due.request); }))
    moment.boxes = std::make_shared<const std::vector<passes::Box3d>>(
        passes::boxes_of_instances(scene_.scene(), poses_));
  deal_out(std::move(asked));
  draw_on_all(frames, moment);
  return true;
}

void ImageService::forget_what_is_over() {
  const std::vector<Key> open = intake_.image_requests();
  for (size_t device = 0; device < device_count(); ++device) maker_at(device).keep_only(open);
  std::erase_if(places_, [&](const auto& entry) {
    const auto& [key, place] = entry;
    if (std::ranges::binary_search(open, key)) return false;
    pixels_of_device_[place.device] -= place.pixels;
    return true;
  });
}

// What cannot be is refused.
std::vector<ImageMaker::Asked> ImageService::resolve(std::vector<state::ImageBook::Due>&& due) {
  std::vector<ImageMaker::Asked> asked;
  for (state::ImageBook::Due& one : due) {
    auto camera = asked_camera(one.request, intake_.world_from_stream(one.asker), poses_, scene_);
    if (const auto* possible = std::get_if<AskedCamera>(&camera)) {
      if (auto too_much = too_much_behind_lens(one.request, *possible)) camera = std::move(*too_much);
    }
    if (const auto* refused = std::get_if<AskedCameraRefused>(&camera)) {
      intake_.refuse_image(one, refused->reason, refused->why);
    } else {
      asked.push_back({std::move(one), std::get<AskedCamera>(camera)});
    }
  }
  return asked;
}

// To the device that has the fewest pixels to draw for the requests that are open; in turns where all have as
// many.
size_t ImageService::place_of(const ImageMaker::Asked& asked) {
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

void ImageService::deal_out(std::vector<ImageMaker::Asked>&& asked) {
  std::vector<std::vector<ImageMaker::Asked>> hands(device_count());
  for (ImageMaker::Asked& one : asked) hands[place_of(one)].push_back(std::move(one));
  for (size_t device = 0; device < hands.size(); ++device) maker_at(device).begin(std::move(hands[device]));
}

// In rounds: what is finished is sent between two of them, so that no more is under way than the devices work
// at.
void ImageService::draw_on_all(gpu::FrameRing& frames, const ImageMaker::Moment& moment) {
  const auto has_work = [&](size_t device) { return maker_at(device).has_work(); };
  for (bool more = true; more;) {
    deliver();
    std::vector<FurtherDevice*> at_work;
    for (const std::unique_ptr<FurtherDevice>& each : further()) {
      if (!each->maker().has_work()) continue;
      each->begin_drawing(scene_, *settings_, moment);
      at_work.push_back(each.get());
    }
    std::exception_ptr failure;  // of any: all have to be waited for
    const auto attempt = [&](auto&& action) {
      try {
        action();
      } catch (...) {
        failure = std::current_exception();
      }
    };
    attempt([&] { first_.draw(frames, moment); });
    for (FurtherDevice* each : at_work) {
      attempt([&] {
        if (Result<void> drawn = each->finish(); !drawn) each->maker().refuse_rest(drawn.error().message);
      });
    }
    if (failure) std::rethrow_exception(failure);
    more = false;
    for (size_t device = 0; device < device_count(); ++device) {
      refuse_what_had_no_room(maker_at(device));
      more |= has_work(device);
    }
  }
}

void ImageService::refuse_what_had_no_room(ImageMaker& maker) {
  for (const ImageMaker::Refused& refused : maker.take_refused())
    intake_.refuse_image(refused.due, refused.reason, refused.why);
}

void ImageService::deliver() {
  const auto send = [&](state::ImageBook::Asker asker, const wire::ImageFrame& frame,
                        const AskedImage& pixels) {
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

void ImageService::wait(const Mark& mark) const {
  for (size_t device = 0; device < mark.size(); ++device) device_at(device).wait(mark[device]);
}

}  // namespace fire3dv::app

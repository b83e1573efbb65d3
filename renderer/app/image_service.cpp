#include "renderer/app/image_service.h"

#include <algorithm>
#include <chrono>

namespace fire3dv::app {
namespace {

// Of the images of one submission: what comes back is kept in memory of the host until it is sent.
constexpr uint64_t kMostSubmittedBytes = uint64_t{64} << 20;
constexpr uint64_t kMostTogetherBytes = uint64_t{64} << 20;  // of visibility, of cameras drawn at once

int64_t monotonic_now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

passes::ImageOutputs drawn_outputs(const wire::ImageRequest& request) {
  return passes::with_sources(outputs_of(request.outputs));
}

uint64_t bytes_back(const wire::ImageRequest& request) {
  return wire::pixel_bytes_of(request.intrinsics.width, request.intrinsics.height,
                              bits_of(drawn_outputs(request)), 0);
}

bool has_lens(const AskedCamera& camera) {
  return camera.lens.model != passes::LensModel::none;
}

bool wants_boxes(const wire::ImageRequest& request) {
  return (request.outputs & (wire::kBoxes2d | wire::kBoxes3d)) != 0;
}

bool wants_motion(const wire::ImageRequest& request) {
  return (request.outputs & wire::kMotion) != 0;
}

}  // namespace

// The targets that an image is drawn into have some 20 times its bytes with 4 samples.
state::ImageAbilities image_abilities(const passes::SceneRenderer& renderer) {
  state::ImageAbilities abilities{.most_pixel_bytes = uint64_t{64} << 20};
  abilities.lenses = true;
  abilities.outputs = 0;
  for (uint32_t bit = 0; bit < wire::kImageOutputCount; ++bit) {
    if (renderer.can_take(passes::with_sources(outputs_of(1u << bit)))) abilities.outputs |= 1u << bit;
  }
  return abilities;
}

bool ImageService::draw_due(gpu::FrameRing& frames) {
  std::erase_if(histories_, [&](const auto& kept) {
    return !intake_.is_image_request_open(kept.first.first, kept.first.second);
  });
  std::vector<state::ImageBook::Due> due = intake_.take_due_images(monotonic_now_ns());
  if (due.empty()) return false;
  const std::vector<Asked> asked = resolve(std::move(due));
  Boxes boxes;
  if (std::any_of(asked.begin(), asked.end(), [](const Asked& a) { return wants_boxes(a.due.request); }))
    boxes = std::make_shared<const std::vector<passes::Box3d>>(
        passes::boxes_of_instances(scene_.scene(), poses_));

  gpu::Recorder* recorder = nullptr;
  uint64_t bytes = 0;
  passes::OfFrame of_frame = passes::OfFrame::first;
  const auto submit = [&] {
    if (recorder) readback_.submitted(frames.submit());
    recorder = nullptr;
    bytes = 0;
  };
  for (size_t first = 0; first < asked.size();) {
    const std::span<const Asked> rest = std::span(asked).subspan(first);
    const std::span<const Asked> together = rest.first(how_many_together(rest));
    first += together.size();
    if (bytes >= kMostSubmittedBytes) submit();
    if (!make_room(together)) continue;
    if (!recorder) {
      deliver();  // so that no more are under way than the device works at
      recorder = &frames.begin();
    }
    record(*recorder, frames.belt(), together, boxes, std::exchange(of_frame, passes::OfFrame::further));
    bytes += together.size() * bytes_back(together[0].due.request);
  }
  submit();
  return true;
}

// What cannot be is refused.
std::vector<ImageService::Asked> ImageService::resolve(std::vector<state::ImageBook::Due>&& due) {
  std::vector<Asked> asked;
  for (state::ImageBook::Due& one : due) {
    auto camera = asked_camera(one.request, intake_.world_from_stream(one.asker), poses_, scene_);
    if (const auto* refused = std::get_if<AskedCameraRefused>(&camera)) {
      intake_.refuse_image(one, refused->reason, refused->why);
    } else {
      asked.push_back({std::move(one), std::get<AskedCamera>(camera)});
    }
  }
  return asked;
}

// Of images that stand side by side, how many of the first ones are drawn at once.
size_t ImageService::how_many_together(std::span<const Asked> rest) const {
  const wire::ImageRequest& first = rest[0].due.request;
  const passes::ImageOutputs outputs = drawn_outputs(first);
  const bool smoothed = outputs.color_srgb8 && renderer_.post_settings().fxaa;
  if (smoothed || has_lens(rest[0].camera) || !renderer_.can_take(outputs, 2)) return 1;
  const uint64_t view_bytes = uint64_t{8} * static_cast<uint32_t>(renderer_.samples()) *
                              first.intrinsics.width * first.intrinsics.height;
  const uint64_t most =
      std::min<uint64_t>({kMostTogetherBytes / view_bytes,
                          device_.limits().maxImageDimension2D / first.intrinsics.height, rest.size()});
  size_t count = 1;
  while (count < most) {
    const wire::ImageRequest& next = rest[count].due.request;
    if (next.intrinsics.width != first.intrinsics.width ||
        next.intrinsics.height != first.intrinsics.height || next.outputs != first.outputs ||
        has_lens(rest[count].camera))
      break;
    ++count;
  }
  return count;
}

// Not enough memory is no reason to end: the images are refused.
bool ImageService::make_room(std::span<const Asked> together) {
  const glm::uvec2 size = together[0].camera.pinhole.image_px;
  const VkExtent2D extent{size.x, size.y}, before = renderer_.extent();
  const auto views = static_cast<uint32_t>(together.size()), views_before = renderer_.views();
  try {
    renderer_.set_size(extent, views);
    return true;
  } catch (const gpu::VulkanFailure& failure) {
    const bool is_memory =
        failure.result == VK_ERROR_OUT_OF_DEVICE_MEMORY || failure.result == VK_ERROR_OUT_OF_HOST_MEMORY;
    if (!is_memory) throw;
  }
  renderer_.set_size(before, views_before);
  for (const Asked& asked : together)
    intake_.refuse_image(asked.due, wire::ImageRefusal::too_large,
                         "the device has no memory for an image of " + std::to_string(extent.width) + " x " +
                             std::to_string(extent.height) + "; ask for a smaller one");
  return false;
}

void ImageService::record(gpu::Recorder& recorder, gpu::UploadBelt& belt, std::span<const Asked> together,
                          const Boxes& boxes, passes::OfFrame of_frame) {
  const wire::ImageRequest& first = together[0].due.request;
  const passes::ImageOutputs outputs = drawn_outputs(first);
  const bool through_lens = has_lens(together[0].camera);
  Tag tag;
  std::vector<passes::View> views;
  for (const Asked& asked : together) {
    const state::ImageBook::Due& due = asked.due;
    const passes::Intrinsics& used = asked.camera.intrinsics;
    passes::View& view =
        views.emplace_back(passes::make_view(asked.camera.pinhole, asked.camera.world_from_camera));
    view.camera = due.request.node;
    view.exposure = asked.camera.exposure;
    wire::ImageFrame frame;
    frame.request = due.request.id;
    frame.number = due.number;
    frame.epoch = due.request.epoch;
    frame.sequence = due.sequence;
    frame.sim_time_ns = due.sim_time_ns;
    frame.world_from_camera = affine_of(asked.camera.world_from_camera);
    frame.intrinsics = {used.image_px.x, used.image_px.y, used.fx_px,
                        used.fy_px,      used.cx_px,      used.cy_px,
                        used.near_m,     used.far_m,      due.request.intrinsics.lens};
    tag.images.push_back({due.asker, due.request.outputs, std::move(frame)});
  }
  std::vector<passes::CameraHistory> histories = take_histories(together);
  renderer_.record(recorder, belt, poses_, views, through_lens ? passes::behind_lens(outputs) : outputs,
                   histories, of_frame);
  keep_histories(together, std::move(histories));

  tag.taken.width = first.intrinsics.width;
  tag.taken.height = first.intrinsics.height;
  tag.taken.views = static_cast<uint32_t>(together.size());
  tag.taken.color_srgb8 = outputs.color_srgb8;
  if (wants_boxes(first)) tag.taken.boxes = boxes;
  if (through_lens) {
    read_back_through_lens(recorder, belt, together[0].camera, outputs, std::move(tag));
  } else {
    read_back(recorder, outputs, std::move(tag));
  }
}

void ImageService::read_back(gpu::Recorder& recorder, const passes::ImageOutputs& outputs, Tag&& tag) {
  passes::ReadbackBelt<Tag>::Planes planes;
  if (outputs.any_plane()) {
    tag.taken.places = renderer_.plane_places();
    planes = {&renderer_.planes(), passes::bytes_of(tag.taken.places)};
  }
  gpu::Image* const image = outputs.color_srgb8 ? &renderer_.image() : nullptr;
  readback_.record(recorder, image, renderer_.image().extent, planes, std::move(tag));
}

void ImageService::read_back_through_lens(gpu::Recorder& recorder, gpu::UploadBelt& belt,
                                          const AskedCamera& camera, const passes::ImageOutputs& outputs,
                                          Tag&& tag) {
  passes::LensPass::Source source{camera.pinhole, nullptr, nullptr, {}};
  if (outputs.color_srgb8) source.color = &renderer_.image();
  if (outputs.any_plane()) {
    source.planes = &renderer_.planes();
    source.places = renderer_.plane_places();
  }
  lens_.record(recorder, belt, source, {camera.intrinsics, camera.lens, outputs});
  tag.taken.places = lens_.places();
  const VkExtent2D extent{camera.intrinsics.image_px.x, camera.intrinsics.image_px.y};
  readback_.record(recorder, nullptr, extent, {&lens_.result(), lens_.result_bytes()}, std::move(tag));
}

std::vector<passes::CameraHistory> ImageService::take_histories(std::span<const Asked> together) {
  std::vector<passes::CameraHistory> histories;
  if (!wants_motion(together[0].due.request)) return histories;
  for (const Asked& asked : together)
    histories.push_back(std::move(histories_[{asked.due.asker, asked.due.request.id}]));
  return histories;
}

void ImageService::keep_histories(std::span<const Asked> together,
                                  std::vector<passes::CameraHistory>&& histories) {
  for (size_t i = 0; i < histories.size(); ++i)
    histories_[{together[i].due.asker, together[i].due.request.id}] = std::move(histories[i]);
}

void ImageService::deliver() {
  readback_.poll([&](Tag tag, VkExtent2D, std::span<const uint8_t> bytes) {
    for (uint32_t view = 0; view < tag.images.size(); ++view) {
      Image& image = tag.images[view];
      const AskedImage pixels(tag.taken, view, image.bits, bytes);
      pixels.describe_to(image.frame);
      intake_.send_image(image.asker, image.frame, [&](std::span<std::byte> to) { pixels.copy_to(to); });
    }
  });
}

}  // namespace fire3dv::app

#include "programs/drake/render/image_renderer.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/log.h"
#include "programs/drake/request/gltf_scene.h"
#include "renderer/camera/default_look.h"
#include "renderer/sinks/png.h"

namespace fire3dv::drake {
namespace {

constexpr size_t kWarningsShown = 5;  // of a loaded scene

// Settings of depth and label images: geometry only, one sample.
settings::DrawSettings geometry_settings(settings::DrawSettings settings) {
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.levels_of_detail = settings::LevelsOfDetail::off;
  settings.post.fxaa = false;
  return settings;
}

// Drake measures from the upper left corner of the image, the renderer from the centre of its first pixel.
passes::Intrinsics intrinsics_of(const RenderRequest& request) {
  passes::Intrinsics intrinsics;
  intrinsics.fx_px = static_cast<float>(request.focal_x_px);
  intrinsics.fy_px = static_cast<float>(request.focal_y_px);
  intrinsics.cx_px = static_cast<float>(request.center_x_px - 0.5);
  intrinsics.cy_px = static_cast<float>(request.center_y_px - 0.5);
  intrinsics.image_px = {request.width, request.height};
  intrinsics.near_m = static_cast<float>(request.near_m);
  intrinsics.far_m = static_cast<float>(request.far_m);
  return intrinsics;
}

template <typename Value>
std::vector<Value> values_of(const sinks::FrameImage& image) {
  const std::vector<uint8_t>& bytes = image.planes.front().bytes;
  std::vector<Value> values(bytes.size() / sizeof(Value));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
  return values;
}

wire::ImageOutputs outputs_of(ImageType type) {
  switch (type) {
    case ImageType::depth:
      return wire::ImageOutputs(wire::kDepthF32);
    case ImageType::label:
      return wire::ImageOutputs(wire::kInstanceU32);
    case ImageType::color:
      break;
  }
  return wire::ImageOutputs(wire::kColorSrgb8);
}

void paint_labels(sinks::FrameImage& image, const CachedScene& scene, const GltfScene& gltf) {
  image.rgba8.reserve(size_t{4} * image.width * image.height);
  for (const uint32_t instance : values_of<uint32_t>(image)) {
    const Rgb8 label = scene.label_of(instance - 1, gltf);  // instance 0, the background, wraps around
    image.rgba8.insert(image.rgba8.end(), {label[0], label[1], label[2], 255});
  }
  image.planes.clear();
}

Result<RenderedImage> png_of(const sinks::FrameImage& image) {
  const Result<std::vector<uint8_t>> png = sinks::encode_png(image);
  if (!png) return png.error();
  return RenderedImage{"image/png", std::string(png->begin(), png->end())};
}

}  // namespace

ImageRenderer::ImageRenderer(gpu::Device& device, const app::Options& options,
                             const settings::DrawSettings& color, const RenderSettings& settings,
                             std::function<bool()> stop_requested)
    : device_(device),
      options_(options),
      color_(color),
      settings_(settings),
      stop_requested_(std::move(stop_requested)),
      frames_(device),
      captures_(device) {}

Result<void> ImageRenderer::check_camera(const RenderRequest& request) {
  if (auto good = passes::check(intrinsics_of(request)); !good)
    return Error{"the camera cannot be rendered: " + good.error().message};
  return {};
}

bool ImageRenderer::has(const GltfScene& gltf, bool is_color) const {
  return std::ranges::any_of(entries_, [&](const Entry& entry) {
    return entry.is_color == is_color && entry.content == gltf.content();
  });
}

settings::DrawSettings ImageRenderer::settings_of(bool is_color) const {
  return is_color ? color_ : geometry_settings(color_);
}

Result<std::unique_ptr<LoadedDrakeScene>> ImageRenderer::load(GltfScene& gltf, bool is_color) const {
  const settings::DrawSettings settings = settings_of(is_color);
  SceneLoading loading;
  loading.has_key_light =
      is_color && app::wants_key_light(options_.key_light, app::lights_by_choice(options_));
  loading.levels = passes::levels_for(settings.levels_of_detail);
  loading.max_bytes = settings_.max_scene_bytes;
  loading.max_image_bytes = settings_.max_image_bytes;
  loading.stop_requested = stop_requested_;
  Result<std::unique_ptr<LoadedDrakeScene>> loaded = load_scene(gltf, loading);
  if (!loaded) return loaded.error();
  const scene::Scene& scene = (*loaded)->loaded.scene;
  for (size_t i = 0; i < std::min(scene.warnings.size(), kWarningsShown); ++i)
    print_log_line("fire3dv-drake", warning(scene.warnings[i]));
  if (scene.textures.size() > settings.max_textures)
    return Error{"the scene has " + std::to_string(scene.textures.size()) + " textures: at most " +
                 std::to_string(settings.max_textures) + " are drawn"};
  return loaded;
}

Result<void> ImageRenderer::add(const GltfScene& gltf, bool is_color,
                                std::unique_ptr<LoadedDrakeScene> loaded) {
  while (entries_.size() >= settings_.max_scenes) entries_.pop_back();
  const uint64_t host_bytes = loaded->bytes, device_bytes = device_.allocated_bytes();
  try {
    std::optional<settings::PostSettings> estimated;
    if (is_color && options_.draw.post.estimated) estimated = options_.draw.post;
    entries_.push_front({is_color, gltf.content(), host_bytes,
                         std::make_unique<CachedScene>(device_, settings_of(is_color), std::move(loaded),
                                                       std::move(estimated))});
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    entries_.clear();  // the next request finds all memory free
    return Error{"the device has no memory for the scene; simplify its meshes and textures"};
  }
  entries_.front().bytes += device_.allocated_bytes() - std::min(device_bytes, device_.allocated_bytes());
  make_room();
  return {};
}

// Drops the scenes that were not used for the longest time.
void ImageRenderer::make_room() {
  const auto total = [&] {
    uint64_t sum = 0;
    for (const Entry& entry : entries_) sum += entry.bytes;
    return sum;
  };
  while (entries_.size() > 1 && total() > settings_.max_cached_bytes) entries_.pop_back();
}

Result<sinks::FrameImage> ImageRenderer::draw(const RenderRequest& request, const GltfScene& gltf) {
  const bool is_color = request.type == ImageType::color;
  const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.is_color == is_color && entry.content == gltf.content();
  });
  FIRE3DV_ASSERT(found != entries_.end());
  std::rotate(entries_.begin(), found, found + 1);
  Entry& entry = entries_.front();
  const uint64_t device_bytes = device_.allocated_bytes();
  entry.scene->set_transforms(gltf);
  const passes::View view = passes::make_view(intrinsics_of(request), glm::mat4(gltf.world_from_camera()));
  Result<sinks::FrameImage> image = draw(*entry.scene, view, request, outputs_of(request.type));
  // Images of the request's size are the scene's, too.
  entry.bytes += device_.allocated_bytes() - std::min(device_bytes, device_.allocated_bytes());
  if (image && request.type == ImageType::label) paint_labels(*image, *entry.scene, gltf);
  make_room();
  return image;
}

Result<RenderedImage> ImageRenderer::encode(sinks::FrameImage&& image, const RenderRequest& request) const {
  if (request.type != ImageType::depth) return png_of(image);
  return RenderedImage{"image/tiff",
                       encode_depth(values_of<float>(image), request.width, request.height,
                                    {request.min_depth_m, request.max_depth_m}, settings_.depth_format)};
}

Result<sinks::FrameImage> ImageRenderer::draw(CachedScene& scene, const passes::View& view,
                                              const RenderRequest& request, wire::ImageOutputs outputs) {
  passes::SceneRenderer& renderer = scene.renderer();
  const Result<passes::PreparedFrame> prepared =
      renderer.prepare({.extent = {request.width, request.height}, .outputs = wire::with_sources(outputs)});
  if (!prepared) return prepared.error();
  gpu::Recorder& recorder = frames_.begin();
  renderer.record(*prepared, recorder, frames_.staging(), scene.poses(), view);
  captures_.record(recorder, renderer, outputs, scene.scene(), scene.poses(), {});
  const uint64_t submitted = frames_.submit();
  captures_.submitted(submitted);
  device_.wait(submitted);
  std::optional<sinks::FrameImage> image;
  captures_.poll([&](sinks::FrameImage&& finished) { image = std::move(finished); });
  (void)frames_.take_finished();
  FIRE3DV_ASSERT(image.has_value());
  return std::move(*image);
}

}  // namespace fire3dv::drake

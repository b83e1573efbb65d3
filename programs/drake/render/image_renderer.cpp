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

Result<RenderedImage> ImageRenderer::render(const RenderRequest& request) {
  const passes::Intrinsics intrinsics = intrinsics_of(request);
  if (auto good = passes::check(intrinsics); !good)
    return Error{"the camera cannot be rendered: " + good.error().message};
  Result<GltfScene> gltf = GltfScene::read(request.scene, request.type);
  if (!gltf) return gltf.error();
  const bool is_color = request.type == ImageType::color;
  bool was_cached = false;
  Result<CachedScene*> scene = find_or_load(*gltf, is_color, &was_cached);
  if (!scene) return scene.error();
  (*scene)->set_transforms(*gltf);
  const passes::View view = passes::make_view(intrinsics, glm::mat4(gltf->world_from_camera()));
  Result<sinks::FrameImage> image = draw(**scene, view, request, outputs_of(request.type));
  if (!image) return image.error();
  Result<RenderedImage> result = RenderedImage{};
  if (request.type == ImageType::depth) {
    result->content_type = "image/tiff";
    result->file = encode_depth(values_of<float>(*image), request.width, request.height,
                                {request.min_depth_m, request.max_depth_m}, settings_.depth_format);
  } else {
    if (request.type == ImageType::label) paint_labels(*image, **scene, *gltf);
    result = png_of(*image);
  }
  if (result) result->was_cached = was_cached;
  return result;
}

Result<CachedScene*> ImageRenderer::find_or_load(GltfScene& gltf, bool is_color, bool* was_cached) {
  const auto found = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.is_color == is_color && entry.content == gltf.content();
  });
  *was_cached = found != entries_.end();
  if (*was_cached) {
    std::rotate(entries_.begin(), found, found + 1);
    return entries_.front().scene.get();
  }
  settings::DrawSettings settings = is_color ? color_ : geometry_settings(color_);
  SceneLoading loading;
  loading.has_key_light = is_color && app::wants_key_light(options_.key_light, !options_.environment.empty());
  loading.levels = passes::levels_for(settings.levels_of_detail);
  loading.max_bytes = settings_.max_scene_bytes;
  loading.stop_requested = stop_requested_;
  Result<std::unique_ptr<LoadedDrakeScene>> loaded = load_scene(gltf, loading);
  if (!loaded) return loaded.error();
  const scene::Scene& scene = (*loaded)->loaded.scene;
  for (size_t i = 0; i < std::min(scene.warnings.size(), kWarningsShown); ++i)
    print_log_line("fire3dv-drake", warning(scene.warnings[i]));
  if (is_color) (void)app::set_exposure(options_.draw.post, scene, settings);
  if (scene.textures.size() > settings.max_textures)
    return Error{"the scene has " + std::to_string(scene.textures.size()) + " textures: at most " +
                 std::to_string(settings.max_textures) + " are drawn"};
  make_room_for(gltf.bytes());
  try {
    entries_.push_front({is_color, gltf.content(), gltf.bytes(),
                         std::make_unique<CachedScene>(device_, settings, std::move(*loaded))});
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    entries_.clear();  // the next request finds all memory free
    return Error{"the device has no memory for the scene; simplify its meshes and textures"};
  }
  return entries_.front().scene.get();
}

void ImageRenderer::make_room_for(uint64_t bytes) {
  const auto total = [&] {
    uint64_t sum = bytes;
    for (const Entry& entry : entries_) sum += entry.bytes;
    return sum;
  };
  while (!entries_.empty() &&
         (entries_.size() >= settings_.max_scenes || total() > settings_.max_cached_bytes))
    entries_.pop_back();
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

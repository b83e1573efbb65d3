// Renderer of Drake's images on one device, with a cache of scenes. One thread, but for what says so.
//
// Colour images have the renderer's usual quality. Depth and label images have one sample at each pixel's
// centre, so that no value is a blend of two surfaces.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>

#include "programs/drake/render/cached_scene.h"
#include "programs/drake/render/depth_image.h"
#include "programs/drake/request/form.h"
#include "renderer/app/options/options.h"
#include "renderer/capture/capture.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/frame_ring.h"

namespace fire3dv::drake {

struct RenderSettings {
  DepthFormat depth_format = DepthFormat::float32_m;
  uint32_t max_scenes = 6;  // in the cache
  // Of the cached scenes in memory, the device's included. The newest one stays, whatever its size.
  uint64_t max_cached_bytes = uint64_t{2} << 30;
  uint64_t max_image_bytes = uint64_t{256} << 20;  // of its images; counted before they are decoded
  uint64_t max_scene_bytes = uint64_t{1}
                             << 30;  // of one scene when it is loaded, before its images are decoded
};

struct RenderedImage {
  std::string content_type, file;
};

class ImageRenderer {
 public:
  // options: drawing options. color: settings that they stand for. Both are copied.
  ImageRenderer(gpu::Device& device, const app::Options& options, const settings::DrawSettings& color,
                const RenderSettings& settings, std::function<bool()> stop_requested);

  // Errors are about the request's scene, or about the lack of memory for it.
  static Result<void> check_camera(const RenderRequest& request);                        // any thread
  bool has(const GltfScene& gltf, bool is_color) const;                                  // in the cache
  Result<std::unique_ptr<LoadedDrakeScene>> load(GltfScene& gltf, bool is_color) const;  // any thread
  Result<void> add(const GltfScene& gltf, bool is_color, std::unique_ptr<LoadedDrakeScene> loaded);
  // The scene must be in the cache. The image depends on this request alone.
  Result<sinks::FrameImage> draw(const RenderRequest& request, const GltfScene& gltf);
  Result<RenderedImage> encode(sinks::FrameImage&& image, const RenderRequest& request) const;  // any thread

 private:
  struct Entry {
    bool is_color = false;
    Digest content{};
    uint64_t bytes = 0;  // in memory, the device's included
    std::unique_ptr<CachedScene> scene;
  };
  settings::DrawSettings settings_of(bool is_color) const;
  Result<sinks::FrameImage> draw(CachedScene& scene, const passes::View& view, const RenderRequest& request,
                                 wire::ImageOutputs outputs);
  void make_room();

  gpu::Device& device_;
  const app::Options options_;
  const settings::DrawSettings color_;
  const RenderSettings settings_;
  const std::function<bool()> stop_requested_;
  gpu::FrameRing frames_;
  capture::CaptureQueue captures_;
  std::deque<Entry> entries_;  // newest first
};

}  // namespace fire3dv::drake

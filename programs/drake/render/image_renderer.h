// Renderer of Drake's images on one device, with a cache of scenes. One thread.
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
  uint32_t max_scenes = 6;                        // in the cache
  uint64_t max_cached_bytes = uint64_t{1} << 30;  // of the cached scenes' files
  uint64_t max_scene_bytes = uint64_t{4} << 30;   // of one scene when it is loaded
};

struct RenderedImage {
  std::string content_type, file;
  bool was_cached = false;  // the scene
};

class ImageRenderer {
 public:
  // options: drawing options. color: settings that they stand for. Both are copied.
  ImageRenderer(gpu::Device& device, const app::Options& options, const settings::DrawSettings& color,
                const RenderSettings& settings, std::function<bool()> stop_requested);

  // Errors are about the request's scene, or about the lack of memory for it.
  Result<RenderedImage> render(const RenderRequest& request);

 private:
  struct Entry {
    bool is_color = false;
    Digest content{};
    uint64_t bytes = 0;
    std::unique_ptr<CachedScene> scene;
  };
  Result<CachedScene*> find_or_load(GltfScene& gltf, bool is_color, bool* was_cached);
  Result<sinks::FrameImage> draw(CachedScene& scene, const passes::View& view, const RenderRequest& request,
                                 wire::ImageOutputs outputs);
  void make_room_for(uint64_t bytes);

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

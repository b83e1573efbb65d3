// Marker pass: draws markers of streams into the multisampled HDR colour, with the depth of surfaces; blended
// ones as layers among blended surfaces. One buffer holds the arrays of all markers as they came; vertices
// are generated in the vertex shader. Colours are display-referred: neither exposure nor tone mapping change
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "renderer/gpu/device/vk.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/layers/layer_pass.h"
#include "renderer/passes/markers/text_layout.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/state/marker_registry.h"

namespace fire3dv::passes {

class MarkerPass {
 public:
  MarkerPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples)
      : device_(device), layout_(layout), samples_(samples) {}

  // Uploads values that are new since the last call, and forgets those that are gone.
  void update(gpu::Recorder& recorder, gpu::StagingRing& staging,
              std::span<const state::ShownMarker> markers);

  // Selects the markers of the last update() whose bounds meet the view's frustum, for bounds() and record().
  void select(std::span<const state::ShownMarker> markers, const View& view, VkExtent2D extent);
  // Screen-space bounds of the selected markers. The whole image if one crosses the near plane.
  const VkRect2D& bounds() const { return bounds_; }
  size_t selected_count() const { return selected_.size(); }
  // Of another scene, whose markers may have the same ids.
  void forget() {
    uploaded_.clear();
    selected_.clear();
  }

  struct Frame {
    Targets& targets;  // with colour and depth of the surfaces
    const View& view;
    VkDeviceAddress globals;
    VkRect2D area;            // scissor in the image
    bool in_batches = false;  // see draw_batches.h
  };
  enum class Layer : uint8_t { opaque, blended, overlaid };
  bool has_blended() const;  // of the selected ones
  // Draws the selected markers of some layers.
  void record(gpu::Recorder& recorder, const Frame& frame, std::initializer_list<Layer> layers);
  // The blended ones among other blended draws; valid while frame lives.
  LayerDraws layer_draws(const Frame& frame);

  // Number of bytes uploaded so far, for tests and measurements.
  uint64_t uploaded_bytes() const { return uploaded_bytes_; }
  // True while markers are not drawn for lack of device memory.
  bool lacks_memory() const { return lacks_memory_; }

 private:
  // Arrays of one value in the buffer.
  struct UploadedMarker {
    VkDeviceSize positions = 0, rotations = 0, sizes = 0, colors = 0, end = 0;  // offsets
    uint32_t glyphs = 0;                                                        // of texts
    float reach = 2;  // of the drawn element around its position, in widths: heads of arrows are wide
    bool is_opaque = true;
    scene::Box box;       // of the elements, in marker space, without widths
    uint64_t update = 0;  // last one that showed it
  };
  struct Selected {
    const state::ShownMarker* shown;
    const UploadedMarker* uploaded;
  };
  // How they are drawn: layers of the same names, and the two times of LayerPass.
  enum class Stage : uint8_t { opaque, blended, overlaid, layer_keys, layer_light };
  static constexpr size_t kStageCount = 5;
  enum class Shape : uint8_t { plain, disc, glyph, image };
  static constexpr size_t kShapeCount = 4;
  // Arrays as the shader reads them: those of the marker, glyphs of texts, texels of images.
  struct Elements {
    std::span<const std::byte> positions, rotations, sizes, colors;
    uint32_t glyphs = 0;
    float reach = 2;
  };
  // Arrays made from markers, by id, for one update: none is made twice.
  struct ConvertedArrays {
    std::unordered_map<uint64_t, TextGlyphs> texts;
    std::unordered_map<uint64_t, std::vector<uint32_t>> texels;
  };
  Elements elements_of(const state::ShownMarker& shown, ConvertedArrays& converted);
  static UploadedMarker lay_out_after(VkDeviceSize begin, const Elements& elements);
  void write(gpu::StagingRing& staging, const Elements& elements, const UploadedMarker& uploaded,
             std::vector<VkBufferCopy>& copies, std::vector<VkBuffer>& sources);
  bool grow(VkDeviceSize bytes);
  bool upload_atlas(gpu::Recorder& recorder, gpu::StagingRing& staging);
  static Layer layer_of(const Selected& entry);
  // Back to front.
  std::vector<Selected> sorted(Layer layer, const View& view) const;
  std::vector<gpu::Use> draw_uses();
  const gpu::Pipeline& pipeline(Stage stage, Shape shape);
  class Batches;
  // first_number: of the triangles; returns that of the next draw.
  uint32_t draw(Batches& batches, const Selected& entry, Stage stage, const Frame& frame,
                const LayerStep* step = nullptr, uint32_t first_number = 0);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  VkSampleCountFlagBits samples_;
  std::array<gpu::Pipeline, kStageCount * kShapeCount>
      pipelines_;                      // by stage and shape; created on first use
  std::unique_ptr<GlyphAtlas> atlas_;  // created for the first text
  gpu::Buffer atlas_texels_;
  VkDeviceSize atlas_capacity_ = 0;
  uint64_t atlas_revision_ = 0;  // of the uploaded texels
  uint32_t atlas_rows_ = 0;
  gpu::Buffer elements_;
  VkDeviceSize capacity_ = 0, end_ = 0;
  VkDeviceSize refused_bytes_ = UINT64_MAX;  // the smallest size that the device refused
  bool lacks_memory_ = false;
  std::unordered_map<uint64_t, UploadedMarker> uploaded_;  // by id
  uint64_t update_ = 0;                                    // number of the last one
  std::vector<Selected> selected_;
  VkRect2D bounds_{};
  uint64_t uploaded_bytes_ = 0;
};

}  // namespace fire3dv::passes

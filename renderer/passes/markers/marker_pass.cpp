#include "renderer/passes/markers/marker_pass.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "renderer/passes/resources/draw_batches.h"
#include "shaders/shared/glyph_types.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
using wire::Marker;
using wire::MarkerKind;
namespace access = gpu::access;

static_assert(FIRE3DV_MARKER_TRIANGLES == static_cast<uint32_t>(MarkerKind::triangles));
static_assert(FIRE3DV_MARKER_TEXTS == static_cast<uint32_t>(MarkerKind::texts));
static_assert(FIRE3DV_MARKER_IMAGES == static_cast<uint32_t>(MarkerKind::images));
static_assert(FIRE3DV_MARKER_AXES == static_cast<uint32_t>(MarkerKind::axes));

constexpr VkDeviceSize kAlignment = 16;
constexpr VkDeviceSize kMinCapacity = VkDeviceSize{64} << 10;

VkDeviceSize aligned(VkDeviceSize bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

template <typename Element>
std::span<const std::byte> element_bytes(const std::vector<Element>& elements) {
  return std::as_bytes(std::span(elements));
}

glm::vec3 position_of(const Marker& marker, size_t index) {
  return {marker.positions[index][0], marker.positions[index][1], marker.positions[index][2]};
}

scene::Box box_of(const Marker& marker) {
  scene::Box box;
  for (size_t i = 0; i < marker.positions.size(); ++i) box.add(position_of(marker, i));
  float extent = 0;  // of the largest element, in any direction
  for (const auto& size : marker.sizes)
    extent = std::max(extent, std::hypot(size[0], size[1], size[2] + std::max(size[0], size[1])));
  box.low -= extent;
  box.high += extent;
  return box;
}

// Levels of detail: round shapes in great numbers are small.
struct Detail {
  uint32_t segments, rings;
};
Detail detail_of(const Marker& marker) {
  if (marker.positions.size() > 10'000) return {6, 4};
  if (marker.positions.size() > 500) return {12, 6};
  return {24, 12};
}

// Mean scale of a transform.
float scale_of(const glm::mat4& transform) {
  return std::cbrt(std::abs(glm::determinant(glm::mat3(transform))));
}

float world_width(const state::ShownMarker& shown) {
  return shown.marker->width * scale_of(shown.world_from_marker);
}

// Vertices and instances of a draw.
std::pair<uint32_t, uint32_t> counts_of(const Marker& marker) {
  const auto count = static_cast<uint32_t>(marker.positions.size());
  const auto [segments, rings] = detail_of(marker);
  switch (marker.kind) {
    case MarkerKind::points:
      return {3 * count, 1};
    case MarkerKind::lines:
      return {3 * count, 1};
    case MarkerKind::line_strip:
      return {6 * (count - 1), 1};
    case MarkerKind::arrows:
      return {15 * segments, count / 2};
    case MarkerKind::axes:
      return {18 * count, 1};
    case MarkerKind::boxes:
      return {36, count};
    case MarkerKind::spheres:
      return {6 * segments * rings, count};
    case MarkerKind::cylinders:
      return {12 * segments, count};
    case MarkerKind::capsules:
      return {6 * segments * (rings + 1), count};
    case MarkerKind::triangles:
      return {count, 1};
    case MarkerKind::images:
      return {6 * count, 1};
    case MarkerKind::texts:
      break;  // drawn by glyph
  }
  return {0, 0};
}

bool is_closed(MarkerKind kind) {
  return kind == MarkerKind::arrows || (kind >= MarkerKind::boxes && kind <= MarkerKind::capsules);
}

bool is_opaque(const wire::MarkerImage& image) {
  if (image.channels != 4) return true;
  for (size_t i = 3; i < image.pixels.size(); i += 4)
    if (image.pixels[i] != 0xff) return false;
  return true;
}

// R | G << 8 | B << 16 | A << 24, as the colours of other kinds.
std::vector<uint32_t> texels_of(const wire::MarkerImage& image) {
  std::vector<uint32_t> texels(size_t{image.width} * image.height);
  const size_t channels = image.channels;
  for (size_t i = 0; i < texels.size(); ++i) {
    const uint8_t* const pixel = image.pixels.data() + channels * i;
    const uint32_t red = pixel[0], green = channels == 1 ? red : pixel[1],
                   blue = channels == 1 ? red : pixel[2];
    const uint32_t alpha = channels == 4 ? pixel[3] : 0xffu;
    texels[i] = red | green << 8 | blue << 16 | alpha << 24;
  }
  return texels;
}

// Corners of a box in clip space.
class Corners {
 public:
  Corners(const scene::Box& box, const glm::mat4& clip_from_box) {
    for (size_t i = 0; i < clip_.size(); ++i) {
      const glm::vec3 corner(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                             i & 4 ? box.high.z : box.low.z);
      clip_[i] = clip_from_box * glm::vec4(corner, 1);
    }
  }

  // True if all corners, and so the box, lie beyond one plane of the frustum, which a margin widens. Numbers
  // that are not finite lie inside.
  bool are_outside(glm::vec2 margin_ndc) const {
    const glm::vec2 edge = 1.0f + margin_ndc;
    const auto all = [&](auto&& distance) {
      return std::all_of(clip_.begin(), clip_.end(), [&](const glm::vec4& c) { return distance(c) < 0; });
    };
    return all([&](const glm::vec4& c) { return c.x + edge.x * c.w; }) ||
           all([&](const glm::vec4& c) { return edge.x * c.w - c.x; }) ||
           all([&](const glm::vec4& c) { return c.y + edge.y * c.w; }) ||
           all([&](const glm::vec4& c) { return edge.y * c.w - c.y; }) ||
           all([&](const glm::vec4& c) { return c.w - c.z; });
  }

  // Grows a rectangle in pixels. False if the box crosses the near plane.
  bool add_to(glm::vec2& low, glm::vec2& high, glm::vec2 size, float margin_px) const {
    for (const glm::vec4& clip : clip_) {
      if (!(clip.w > 0) || !(clip.z <= clip.w)) return false;
      const glm::vec2 pixel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size;
      if (!std::isfinite(pixel.x + pixel.y)) return false;
      low = glm::min(low, pixel - margin_px);
      high = glm::max(high, pixel + margin_px);
    }
    return true;
  }

 private:
  std::array<glm::vec4, 8> clip_;
};

glm::vec4 row_of(const glm::mat4& matrix, int row) {
  return {matrix[0][row], matrix[1][row], matrix[2][row], matrix[3][row]};
}

}  // namespace

MarkerPass::Elements MarkerPass::elements_of(const state::ShownMarker& shown, ConvertedArrays& converted) {
  const Marker& marker = *shown.marker;
  Elements elements{element_bytes(marker.positions), element_bytes(marker.rotations),
                    element_bytes(marker.sizes), element_bytes(marker.colors)};
  if (marker.kind == MarkerKind::images) {
    auto found = converted.texels.find(shown.id);
    if (found == converted.texels.end())
      found = converted.texels.emplace(shown.id, texels_of(marker.image)).first;
    elements.colors = element_bytes(found->second);
  }
  if (marker.kind != MarkerKind::texts) return elements;
  if (!atlas_) atlas_ = std::make_unique<GlyphAtlas>();
  auto found = converted.texts.find(shown.id);
  if (found == converted.texts.end())
    found = converted.texts.emplace(shown.id, lay_out(marker, *atlas_)).first;
  const TextGlyphs& glyphs = found->second;
  return {element_bytes(glyphs.positions),
          element_bytes(glyphs.rectangles),
          {},
          element_bytes(glyphs.colors),
          static_cast<uint32_t>(glyphs.positions.size()),
          glyphs.reach};
}

MarkerPass::UploadedMarker MarkerPass::lay_out_after(VkDeviceSize begin, const Elements& elements) {
  UploadedMarker uploaded;
  uploaded.positions = aligned(begin);
  uploaded.rotations = aligned(uploaded.positions + elements.positions.size());
  uploaded.sizes = aligned(uploaded.rotations + elements.rotations.size());
  uploaded.colors = aligned(uploaded.sizes + elements.sizes.size());
  uploaded.end = uploaded.colors + elements.colors.size();
  uploaded.glyphs = elements.glyphs;
  uploaded.reach = elements.reach;
  return uploaded;
}

void MarkerPass::write(gpu::StagingRing& staging, const Elements& elements, const UploadedMarker& uploaded,
                       std::vector<VkBufferCopy>& copies, std::vector<VkBuffer>& sources) {
  if (uploaded.end == uploaded.positions) return;  // spaces alone
  const gpu::StagingRing::Piece piece = staging.allocate(uploaded.end - uploaded.positions);
  const auto copy = [&](std::span<const std::byte> bytes, VkDeviceSize offset) {
    if (!bytes.empty()) std::memcpy(piece.mapped + (offset - uploaded.positions), bytes.data(), bytes.size());
  };
  copy(elements.positions, uploaded.positions);
  copy(elements.rotations, uploaded.rotations);
  copy(elements.sizes, uploaded.sizes);
  copy(elements.colors, uploaded.colors);
  copies.push_back({piece.offset, uploaded.positions, uploaded.end - uploaded.positions});
  sources.push_back(piece.buffer);
  uploaded_bytes_ += uploaded.end - uploaded.positions;
}

// Returns false if the device has no memory; markers are then not drawn until they need less.
bool MarkerPass::grow(VkDeviceSize bytes) {
  if (bytes >= refused_bytes_) return false;
  bytes = std::max(kMinCapacity, bytes);
  try {
    elements_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    refused_bytes_ = bytes;
    end_ = 0;
    return false;
  }
  capacity_ = bytes;
  return true;
}

// Returns false if the device has no memory.
bool MarkerPass::upload_atlas(gpu::Recorder& recorder, gpu::StagingRing& staging) {
  if (!atlas_ || atlas_revision_ == atlas_->revision()) return true;
  const std::span<const uint8_t> texels = atlas_->texels();
  if (texels.size() > atlas_capacity_) {
    const VkDeviceSize capacity = std::max<VkDeviceSize>(2 * texels.size(), VkDeviceSize{256} << 10);
    try {
      atlas_texels_ =
          gpu::create_buffer(device_, capacity, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure)) throw;
      return false;
    }
    atlas_capacity_ = capacity;
  }
  const gpu::StagingRing::Piece piece = staging.write(texels);
  recorder.pass("marker upload", {Use(atlas_texels_, access::transfer_write)}, [&](VkCommandBuffer commands) {
    const VkBufferCopy copy{piece.offset, 0, texels.size()};
    vkCmdCopyBuffer(commands, piece.buffer, atlas_texels_.get(), 1, &copy);
  });
  atlas_revision_ = atlas_->revision();
  atlas_rows_ = atlas_->rows();
  return true;
}

void MarkerPass::update(gpu::Recorder& recorder, gpu::StagingRing& staging,
                        std::span<const state::ShownMarker> markers) {
  std::vector<const state::ShownMarker*> added;
  ConvertedArrays converted;
  VkDeviceSize needed = 0, end = end_;
  ++update_;
  selected_.clear();
  for (const state::ShownMarker& shown : markers) {
    const auto known = uploaded_.find(shown.id);
    if (known == uploaded_.end()) {
      added.push_back(&shown);
      needed = lay_out_after(needed, elements_of(shown, converted)).end;
    } else {
      known->second.update = update_;
      needed = aligned(needed) + (known->second.end - known->second.positions);
    }
  }
  if (uploaded_.size() > markers.size() - added.size())
    std::erase_if(uploaded_, [&](const auto& entry) { return entry.second.update != update_; });
  for (const state::ShownMarker* shown : added) end = lay_out_after(end, elements_of(*shown, converted)).end;
  if (added.empty()) return;
  if (end > capacity_ || !elements_) {
    // Starts over with all markers. Half of the buffer stays free, so that this is seldom.
    uploaded_.clear();
    lacks_memory_ = (!elements_ || 2 * needed > capacity_) && !grow(2 * needed);
    if (lacks_memory_) return;
    added.clear();
    for (const state::ShownMarker& shown : markers) added.push_back(&shown);
    end_ = 0;
  }
  std::vector<VkBufferCopy> copies;
  std::vector<VkBuffer> sources;
  for (const state::ShownMarker* shown : added) {
    const Marker& marker = *shown->marker;
    const Elements elements = elements_of(*shown, converted);
    UploadedMarker uploaded = lay_out_after(end_, elements);
    uploaded.update = update_;
    end_ = uploaded.end;
    const bool has_colors = marker.kind != MarkerKind::axes;
    const bool is_soft = marker.kind == MarkerKind::texts;  // edges of glyphs are blended
    uploaded.is_opaque = !is_soft && is_opaque(marker.image) &&
                         (!has_colors || std::all_of(marker.colors.begin(), marker.colors.end(),
                                                     [](uint32_t color) { return color >> 24 == 0xff; }));
    uploaded.box = box_of(marker);
    write(staging, elements, uploaded, copies, sources);
    uploaded_.insert_or_assign(shown->id, uploaded);
  }
  if (!upload_atlas(recorder, staging)) {
    uploaded_.clear();
    lacks_memory_ = true;
    return;
  }
  if (copies.empty()) return;
  recorder.pass("marker upload", {Use(elements_, access::transfer_write)}, [&](VkCommandBuffer commands) {
    for (size_t i = 0; i < copies.size(); ++i)
      vkCmdCopyBuffer(commands, sources[i], elements_.get(), 1, &copies[i]);
  });
}

void MarkerPass::select(std::span<const state::ShownMarker> markers, const View& view, VkExtent2D extent) {
  selected_.clear();
  const glm::vec2 size(extent.width, extent.height);
  glm::vec2 low = size, high(0);
  bool is_whole = false;
  for (const state::ShownMarker& shown : markers) {
    const auto uploaded = uploaded_.find(shown.id);
    if (uploaded == uploaded_.end()) continue;
    const Marker& marker = *shown.marker;
    scene::Box box = uploaded->second.box;
    const float widest = uploaded->second.reach;
    const bool is_in_pixels = marker.width_unit == wire::MarkerUnit::pixels;
    if (!is_in_pixels) {
      box.low -= widest * marker.width;
      box.high += widest * marker.width;
    }
    const float margin_px = is_in_pixels ? widest * marker.width + 2 : 2;
    const Corners corners(box, view.clip_from_world * shown.world_from_marker);
    if (corners.are_outside(2.0f * margin_px / size)) continue;
    selected_.push_back({&shown, &uploaded->second});
    if (!is_whole) is_whole = !corners.add_to(low, high, size, margin_px);
  }
  low = glm::clamp(glm::floor(low), glm::vec2(0), size);
  high = glm::clamp(glm::ceil(high), glm::vec2(0), size);
  bounds_ = {{0, 0}, {0, 0}};
  if (is_whole)
    bounds_ = {{0, 0}, extent};
  else if (low.x < high.x && low.y < high.y)
    bounds_ = {{static_cast<int32_t>(low.x), static_cast<int32_t>(low.y)},
               {static_cast<uint32_t>(high.x - low.x), static_cast<uint32_t>(high.y - low.y)}};
}

const gpu::Pipeline& MarkerPass::pipeline(Stage stage, Shape shape) {
  gpu::Pipeline& known = pipelines_[kShapeCount * static_cast<size_t>(stage) + static_cast<size_t>(shape)];
  if (known) return known;
  const bool is_keys = stage == Stage::layer_keys;
  const bool in_layers = is_keys || stage == Stage::layer_light;
  std::string fragment_shader = shape == Shape::plain               ? "marker"
                                : shape == Shape::glyph             ? "marker_text"
                                : shape == Shape::image             ? "marker_image"
                                : samples_ == VK_SAMPLE_COUNT_4_BIT ? "marker_disc_4"
                                                                    : "marker_disc";
  // Keys of glyphs and images are those of their rectangles.
  if (is_keys && shape != Shape::disc) fragment_shader = "marker";
  if (in_layers) fragment_shader += is_keys ? "_layers_keys" : "_layers";
  fragment_shader += ".frag";
  gpu::GraphicsPipelineInfo info;
  info.vertex_shader = in_layers ? "marker_layers.vert" : "marker.vert";
  info.fragment_shader = fragment_shader;
  info.samples = samples_;
  if (!in_layers) {
    info.color_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    info.blend = true;
    info.is_display_referred = true;
  }
  info.depth_write = stage == Stage::opaque;
  if (stage == Stage::overlaid) info.depth_compare = VK_COMPARE_OP_ALWAYS;
  known = gpu::create_graphics_pipeline(device_, layout_, info);
  return known;
}

// Draws of one image, in batches where it has a time limit.
class MarkerPass::Batches {
 public:
  // Within rendering.
  Batches(VkCommandBuffer commands, const VkRenderingInfo& rendering, bool in_batches)
      : commands_(commands),
        rendering_(rendering),
        in_batches_(in_batches),
        most_(triangles_per_batch(rendering.renderArea.extent)),
        left_(most_) {}

  VkCommandBuffer commands() const { return commands_; }

  void draw(uint32_t vertices, uint32_t instances) {
    if (!in_batches_) return vkCmdDraw(commands_, vertices, instances, 0, 0);
    // Elements of flat kinds have 3, 6 or 18 vertices; solids are instances.
    constexpr uint32_t kUnit = 18;
    for (uint32_t first = 0; instances == 1 && first < vertices;) {
      const uint32_t count = std::min(vertices - first, std::max(3 * left_ / kUnit, 1u) * kUnit);
      begin_batch(count / 3);
      vkCmdDraw(commands_, count, 1, first, 0);
      first += count;
    }
    const uint32_t triangles = std::max(vertices / 3, 1u);
    for (uint32_t first = 0; instances > 1 && first < instances;) {
      const uint32_t count = std::min(instances - first, std::max(left_ / triangles, 1u));
      begin_batch(count * triangles);
      vkCmdDraw(commands_, vertices, count, 0, first);
      first += count;
    }
  }

 private:
  void begin_batch(uint32_t triangles) {
    if (left_ == 0) {
      end_batch(commands_);
      vkCmdBeginRendering(commands_, &rendering_);
      left_ = most_;
    }
    left_ -= std::min(left_, triangles);
  }

  const VkCommandBuffer commands_;
  const VkRenderingInfo& rendering_;
  const bool in_batches_;
  const uint32_t most_;  // triangles of a batch
  uint32_t left_;
};

MarkerPass::Layer MarkerPass::layer_of(const Selected& entry) {
  if ((entry.shown->marker->flags & wire::kMarkerOverlaid) != 0) return Layer::overlaid;
  return entry.uploaded->is_opaque ? Layer::opaque : Layer::blended;
}

bool MarkerPass::has_blended() const {
  return std::any_of(selected_.begin(), selected_.end(),
                     [](const Selected& entry) { return layer_of(entry) == Layer::blended; });
}

std::vector<MarkerPass::Selected> MarkerPass::sorted(Layer layer, const View& view) const {
  std::vector<Selected> entries;
  for (const Selected& entry : selected_)
    if (layer_of(entry) == layer) entries.push_back(entry);
  if (layer == Layer::opaque) return entries;
  const auto distance = [&](const auto& entry) {
    const scene::Box& box = entry.uploaded->box;
    const glm::vec4 center(0.5f * (box.low + box.high), 1);
    const glm::vec3 offset = glm::vec3(entry.shown->world_from_marker * center) - view.eye_world;
    return glm::dot(offset, offset);
  };
  std::stable_sort(entries.begin(), entries.end(),
                   [&](const auto& a, const auto& b) { return distance(a) > distance(b); });
  return entries;
}

std::vector<Use> MarkerPass::draw_uses() {
  std::vector<Use> uses{Use(elements_, access::draw_read)};
  if (atlas_texels_) uses.push_back(Use(atlas_texels_, access::draw_read));
  return uses;
}

LayerDraws MarkerPass::layer_draws(const Frame& frame) {
  LayerDraws draws;
  draws.uses = draw_uses();
  draws.record = [this, &frame, entries = sorted(Layer::blended, frame.view)](VkCommandBuffer commands,
                                                                              const LayerStep& step) {
    Batches batches(commands, step.rendering, frame.in_batches);
    const Stage stage = step.stage == LayerStep::Stage::keys ? Stage::layer_keys : Stage::layer_light;
    // Behind those of the scene's primitives, unless these are many millions.
    uint32_t number = 1u << (FIRE3DV_LAYER_NUMBER_BITS - 1);
    for (const Selected& entry : entries) number = draw(batches, entry, stage, frame, &step, number);
  };
  return draws;
}

void MarkerPass::record(gpu::Recorder& recorder, const Frame& frame, std::initializer_list<Layer> layers) {
  std::vector<std::pair<Stage, Selected>> drawn;
  for (const Layer layer : layers)
    for (const Selected& entry : sorted(layer, frame.view))
      drawn.emplace_back(static_cast<Stage>(layer), entry);
  if (drawn.empty()) return;
  std::vector<Use> uses = draw_uses();
  uses.emplace_back(frame.targets.depth, access::depth_target);
  uses.emplace_back(frame.targets.hdr, access::color_target);
  recorder.pass("markers", uses, [&](VkCommandBuffer commands) {
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = frame.targets.hdr.view.get();
    color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    depth.imageView = frame.targets.depth.view.get();
    depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    depth.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = frame.area;
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &color;
    rendering.pDepthAttachment = &depth;
    vkCmdBeginRendering(commands, &rendering);
    Batches batches(commands, rendering, frame.in_batches);
    const VkExtent2D extent = frame.targets.extent;
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height),
                              0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &rendering.renderArea);
    for (const auto& [stage, entry] : drawn) draw(batches, entry, stage, frame);
    vkCmdEndRendering(commands);
  });
}

uint32_t MarkerPass::draw(Batches& batches, const Selected& entry, Stage stage, const Frame& frame,
                          const LayerStep* step, uint32_t first_number) {
  const VkCommandBuffer commands = batches.commands();
  const state::ShownMarker& shown = *entry.shown;
  const UploadedMarker& uploaded = *entry.uploaded;
  const Marker& marker = *shown.marker;
  const glm::mat4& world_from_marker = shown.world_from_marker;
  gpu_types::MarkerPush push{};
  push.globals = frame.globals;
  push.positions = elements_.address + uploaded.positions;
  if (!marker.rotations.empty()) push.rotations = elements_.address + uploaded.rotations;
  if (!marker.sizes.empty()) push.sizes = elements_.address + uploaded.sizes;
  const bool is_image = marker.kind == MarkerKind::images;
  if (!marker.colors.empty() || is_image) push.colors = elements_.address + uploaded.colors;
  push.world_from_marker = {row_of(world_from_marker, 0), row_of(world_from_marker, 1),
                            row_of(world_from_marker, 2)};
  const bool is_in_pixels = marker.width_unit == wire::MarkerUnit::pixels;
  push.width = is_in_pixels ? marker.width : world_width(shown);
  push.kind = static_cast<uint32_t>(marker.kind);
  if (!is_in_pixels) push.flags |= FIRE3DV_MARKER_WIDTH_IN_LENGTHS;
  if (marker.rotations.size() > 1) push.flags |= FIRE3DV_MARKER_ROTATION_EACH;
  if (marker.sizes.size() > 1) push.flags |= FIRE3DV_MARKER_SIZE_EACH;
  if (marker.colors.size() > 1) push.flags |= FIRE3DV_MARKER_COLOR_EACH;
  const Detail detail = detail_of(marker);
  push.segments = detail.segments;
  push.rings = detail.rings;
  // Arrows are built in the world, where nothing is mirrored.
  const bool is_mirrored =
      glm::determinant(glm::mat3(world_from_marker)) < 0 && marker.kind != MarkerKind::arrows;
  const bool is_text = marker.kind == MarkerKind::texts;
  auto [vertices, instances] = counts_of(marker);
  if (is_text) {
    if (uploaded.glyphs == 0) return first_number;
    vertices = 6 * uploaded.glyphs;
    instances = 1;
    push.rotations = elements_.address + uploaded.rotations;
    push.sizes = atlas_texels_.address;
    push.segments = atlas_rows_;
  }
  if (is_image) {
    push.segments = marker.image.width;
    push.rings = marker.image.height;
  }
  const Shape shape = is_text                             ? Shape::glyph
                      : is_image                          ? Shape::image
                      : marker.kind == MarkerKind::points ? Shape::disc
                                                          : Shape::plain;
  if (step) {
    push.target = step->target;
    push.pass = step->pass;
    push.first_number = first_number;
    push.triangles = vertices / 3;
  }
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline(stage, shape).get());
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
  vkCmdSetCullMode(commands, is_closed(marker.kind) ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE);
  vkCmdSetFrontFace(commands, is_mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  batches.draw(vertices, instances);
  return first_number + instances * (vertices / 3);
}

}  // namespace fire3dv::passes

// Image outputs: the one table of their names and formats, and sets of them. The client's API, command lines,
// render passes and files all read it. SPEC section 13 is normative for bits and formats.
//
// Pixels of planes come from one visibility buffer of one camera, so that they agree. Planes other than
// colours show the surface at the pixel's centre without filtering; lines and points appear in colours only.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::wire {

// The numbers are part of the protocol.
enum ImageOutput : uint32_t {
  kColorSrgb8 = 1u << 0,      // red, green, blue after tone mapping, sRGB-encoded; 255
  kColorLinearF16 = 1u << 1,  // red, green, blue before exposure and tone mapping; 1
  kDepthF32 = 1u << 2,        // metres along the camera's axis; infinite for the background
  kInstanceU32 = 1u << 3,     // node index + 1; 0: background
  kSemanticU32 = 1u << 4,     // class of the node; 0: none or background
  // World-space unit normal without normal maps, on the visible side, and 0; all 0 for the background.
  kNormal = 1u << 5,
  // Pixels right and down since the camera's last image; 0 in its first, NaN where the surface was behind the
  // camera or its node hidden. Includes deformation by skins, morph targets and replaced vertices.
  kMotion = 1u << 6,
  kBoxes2d = 1u << 7,  // BoxRecord2d per visible instance
  kBoxes3d = 1u << 8,  // BoxRecord3d per visible instance
  // Material of the surface: linear base colour and 1; perceptual roughness and metallic, 0 to 1. All 0 for
  // the background.
  kAlbedoF16 = 1u << 9,
  kRoughnessF32 = 1u << 10,
  kMetallicF32 = 1u << 11,
  kPositionF32 = 1u << 12,  // x, y, z of the surface in the world in metres, and 1; all 0 for the background
  // How the camera's last image showed the point that is visible now: 0 seen (also the background, and in its
  // first image), 1 hidden by something nearer or as a node, 2 outside of the image.
  kOcclusionU32 = 1u << 13,
  kAmodal = 1u << 14,  // silhouettes of instances drawn alone, as masks and AmodalRecords; in files only
};
constexpr uint32_t kImageOutputCount = 15;
constexpr uint32_t kAllImageOutputs = (1u << kImageOutputCount) - 1;
constexpr uint32_t kRequestableOutputs = kAllImageOutputs & ~uint32_t{kAmodal};  // of requested images

// Element formats. The numbers are part of the protocol.
enum class ImageFormat : uint8_t {
  rgba8 = 1,
  rgba16f = 2,
  r32f = 3,
  r32u = 4,
  rg32f = 5,
  box2d = 6,
  box3d = 7,
  rgba32f = 8,
  amodal = 9,
};

// 2D bounding box of an instance's visible pixels: min inclusive, max exclusive, in pixels.
struct BoxRecord2d {
  uint32_t instance, semantic;
  uint32_t min_x, min_y, max_x, max_y;
  uint32_t pixels;  // number of visible pixels
  uint32_t reserved;
};
static_assert(sizeof(BoxRecord2d) == 32);

// 3D bounding box of a node's mesh: the cube [-0.5, 0.5]^3 transformed by this matrix.
struct BoxRecord3d {
  uint32_t instance, semantic;
  std::array<float, 12> world_from_box;  // row-major
  uint32_t reserved[2];
};
static_assert(sizeof(BoxRecord3d) == 64);

// Silhouette of an instance drawn alone, clipped at the image's border. A pixel belongs to it if its centre
// is covered, or if the image shows the instance there.
struct AmodalRecord {
  uint32_t instance, semantic;
  uint32_t min_x, min_y, max_x, max_y;  // of the silhouette, in pixels, as in BoxRecord2d
  uint32_t pixels;                      // of the silhouette
  uint32_t visible_pixels;              // that show the instance
  uint32_t is_truncated;                // 1: a part of the instance is outside of the image
  uint32_t reserved;
};
static_assert(sizeof(AmodalRecord) == 40);

struct ImageOutputInfo {
  ImageOutput output;
  std::string_view api_name;  // of SPEC.md, the C client and Python
  std::string_view cli_name;  // of command lines, file names and frames.jsonl
  ImageFormat format;
  uint32_t channels;            // numbers per pixel; lists: 0
  uint32_t element_bytes;       // of a pixel, or of a record
  std::string_view numpy_type;  // of a number, little-endian; lists: empty
  bool is_boxes;                // a list of records, not a plane of pixels
  bool needs_ids;               // derived from the ids and depths of the visible surfaces
};

// In the order of the bits.
inline constexpr std::array<ImageOutputInfo, kImageOutputCount> kImageOutputTable{{
    {kColorSrgb8, "color_srgb8", "color", ImageFormat::rgba8, 4, 4, "|u1", false, false},
    {kColorLinearF16, "color_linear_f16", "linear", ImageFormat::rgba16f, 4, 8, "<f2", false, false},
    {kDepthF32, "depth_f32", "depth", ImageFormat::r32f, 1, 4, "<f4", false, true},
    {kInstanceU32, "instance_u32", "instance", ImageFormat::r32u, 1, 4, "<u4", false, true},
    {kSemanticU32, "semantic_u32", "semantic", ImageFormat::r32u, 1, 4, "<u4", false, true},
    {kNormal, "normal", "normal", ImageFormat::rgba16f, 4, 8, "<f2", false, true},
    {kMotion, "motion", "motion", ImageFormat::rg32f, 2, 8, "<f4", false, true},
    {kBoxes2d, "boxes2d", "boxes2d", ImageFormat::box2d, 0, sizeof(BoxRecord2d), "", true, true},
    {kBoxes3d, "boxes3d", "boxes3d", ImageFormat::box3d, 0, sizeof(BoxRecord3d), "", true, true},
    {kAlbedoF16, "albedo_f16", "albedo", ImageFormat::rgba16f, 4, 8, "<f2", false, true},
    {kRoughnessF32, "roughness_f32", "roughness", ImageFormat::r32f, 1, 4, "<f4", false, true},
    {kMetallicF32, "metallic_f32", "metallic", ImageFormat::r32f, 1, 4, "<f4", false, true},
    {kPositionF32, "position_f32", "position", ImageFormat::rgba32f, 4, 16, "<f4", false, true},
    {kOcclusionU32, "occlusion_u32", "occlusion", ImageFormat::r32u, 1, 4, "<u4", false, true},
    {kAmodal, "amodal", "amodal", ImageFormat::amodal, 0, sizeof(AmodalRecord), "", true, true},
}};

const ImageOutputInfo& info_of(ImageOutput output);
const ImageOutputInfo& info_at(uint32_t bit);  // bit: number of the output's bit, below kImageOutputCount
inline std::string image_output_name(uint32_t bit) {
  return std::string(info_at(bit).api_name);
}
// Bytes of all outputs of a request; box lists count with max_boxes records.
uint64_t pixel_bytes_of(uint32_t width, uint32_t height, uint32_t outputs, uint32_t max_boxes);

// Looks up an output by either name; null: there is none.
const ImageOutputInfo* find_image_output(std::string_view name);

// Set of outputs. Its bits are those of ImageRequest::outputs.
class ImageOutputs {
 public:
  constexpr ImageOutputs() = default;  // colours for displays
  constexpr explicit ImageOutputs(uint32_t bits) : bits_(bits) {}

  // Colours and all planes, no lists.
  static constexpr ImageOutputs all_planes() { return ImageOutputs(kAllPlanes); }

  constexpr uint32_t bits() const { return bits_; }
  constexpr bool has(ImageOutput output) const { return (bits_ & output) != 0; }
  constexpr void add(ImageOutput output) { bits_ |= output; }
  constexpr void remove(ImageOutput output) { bits_ &= ~uint32_t{output}; }

  constexpr bool has_boxes() const { return (bits_ & (kBoxes2d | kBoxes3d)) != 0; }
  // True for planes other than kColorSrgb8.
  constexpr bool has_planes() const { return (bits_ & (kAllPlanes & ~uint32_t{kColorSrgb8})) != 0; }
  // True if a plane depends on ids and depths.
  constexpr bool has_id_planes() const {
    return (bits_ & (kAllPlanes & ~uint32_t{kColorSrgb8 | kColorLinearF16})) != 0;
  }
  // True if a plane compares the image with the camera's last one.
  constexpr bool needs_last_image() const { return (bits_ & (kMotion | kOcclusionU32)) != 0; }
  // True if a plane describes the surface's material, position or occlusion.
  constexpr bool has_surface_planes() const {
    return (bits_ & (kAlbedoF16 | kRoughnessF32 | kMetallicF32 | kPositionF32 | kOcclusionU32)) != 0;
  }
  constexpr bool shaded() const { return (bits_ & (kColorSrgb8 | kColorLinearF16)) != 0; }
  bool operator==(const ImageOutputs&) const = default;

 private:
  static constexpr uint32_t kAllPlanes = kAllImageOutputs & ~uint32_t{kBoxes2d | kBoxes3d | kAmodal};
  uint32_t bits_ = kColorSrgb8;
};

// Adds the sources of requested outputs: lists need the instance plane, occlusion the depth of the last
// image.
constexpr ImageOutputs with_sources(ImageOutputs outputs) {
  if (outputs.has_boxes() || outputs.has(kAmodal)) outputs.add(kInstanceU32);
  if (outputs.has(kOcclusionU32)) outputs.add(kDepthF32);
  return outputs;
}

// Parses "color,depth,instance": each output at most once, by either name.
Result<ImageOutputs> parse_image_outputs(std::string_view text);

}  // namespace fire3dv::wire

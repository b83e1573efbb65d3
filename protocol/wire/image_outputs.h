// Image outputs: the one table of their names and formats, and sets of them. The client's API, command lines,
// render passes and files all read it. SPEC section 13 is normative for bits and formats.
//
// Pixels of planes come from one visibility buffer of one camera, so that they agree. Planes other than
// colours show the surface at the pixel's centre without filtering; blended surfaces, lines and points appear
// in colours only.
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
  // eye. Excludes mesh deformation.
  kMotion = 1u << 6,
  kBoxes2d = 1u << 7,  // BoxRecord2d per visible instance
  kBoxes3d = 1u << 8,  // BoxRecord3d per visible instance
};
constexpr uint32_t kImageOutputCount = 9;
constexpr uint32_t kAllImageOutputs = (1u << kImageOutputCount) - 1;

// Element formats. The numbers are part of the protocol.
enum class ImageFormat : uint8_t {
  rgba8 = 1,
  rgba16f = 2,
  r32f = 3,
  r32u = 4,
  rg32f = 5,
  box2d = 6,
  box3d = 7,
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

struct ImageOutputInfo {
  ImageOutput output;
  std::string_view api_name;  // of SPEC.md, the C client and Python
  std::string_view cli_name;  // of command lines, file names and frames.jsonl
  ImageFormat format;
  uint32_t channels;            // numbers per pixel; boxes: 0
  uint32_t element_bytes;       // of a pixel, or of a box record
  std::string_view numpy_type;  // of a number, little-endian; boxes: empty
  bool is_boxes;                // a list of box records, not a plane of pixels
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

  // Colours and all planes, no boxes.
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
  constexpr bool shaded() const { return (bits_ & (kColorSrgb8 | kColorLinearF16)) != 0; }
  bool operator==(const ImageOutputs&) const = default;

 private:
  static constexpr uint32_t kAllPlanes = kAllImageOutputs & ~uint32_t{kBoxes2d | kBoxes3d};
  uint32_t bits_ = kColorSrgb8;
};

// Adds the sources of requested outputs: boxes need the instance plane.
constexpr ImageOutputs with_sources(ImageOutputs outputs) {
  if (outputs.has_boxes()) outputs.add(kInstanceU32);
  return outputs;
}

// Parses "color,depth,instance": each output at most once, by either name.
Result<ImageOutputs> parse_image_outputs(std::string_view text);

}  // namespace fire3dv::wire

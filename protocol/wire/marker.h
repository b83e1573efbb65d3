// Marker: geometry that a stream shows besides bodies (contact forces, trajectories, point clouds, frames).
// Markers are keyed by their own name, not bound to a node. SPEC section 12 is normative.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "protocol/wire/affine.h"

namespace fire3dv::wire {

// The numbers are part of the protocol. A kind beyond these is of a later minor version.
enum class MarkerKind : uint8_t {
  points = 0,
  lines = 1,       // segments: pairs of positions
  line_strip = 2,  // connected segments
  arrows = 3,      // pairs of positions: tail and tip
  axes = 4,        // frames: x red, y green, z blue
  boxes = 5,
  spheres = 6,
  cylinders = 7,  // around the element's z
  capsules = 8,   // a cylinder and two half spheres
  triangles = 9,  // triples of positions, both sides
  texts = 10,     // lines of text that face the viewer
  images = 11,    // an image on each rectangle, both sides
};
constexpr size_t kMarkerKindCount = 12;
constexpr size_t kMaxMarkerTexts = 65'536;            // of one marker
constexpr size_t kMaxMarkerTextBytes = 1024;          // UTF-8, of one element
constexpr size_t kMaxMarkerTextsBytes = 1024 * 1024;  // of all elements of one marker
constexpr uint32_t kMaxMarkerImageSide = 1024;        // pixels
inline const char* marker_kind_name(MarkerKind kind) {
  constexpr const char* kNames[] = {"points",  "lines",     "line_strip", "arrows",    "axes",  "boxes",
                                    "spheres", "cylinders", "capsules",   "triangles", "texts", "images"};
  static_assert(std::size(kNames) == kMarkerKindCount);
  return kNames[static_cast<size_t>(kind)];
}

enum class MarkerUnit : uint8_t { pixels = 0, lengths = 1 };

enum MarkerFlags : uint32_t {
  kMarkerOverlaid = 1u << 0,  // in front of all surfaces: not hidden by depth
};

// Pixels of 8 bits, rows from the top, without padding: sRGB, straight alpha.
struct MarkerImage {
  uint32_t width = 0, height = 0;  // pixels; 0 in markers without an image
  uint8_t channels = 0;            // 1 grey, 3 red green blue, 4 red green blue alpha
  std::vector<uint8_t> pixels;
  bool operator==(const MarkerImage&) const = default;
};

struct Marker {
  MarkerKind kind = MarkerKind::points;
  MarkerUnit width_unit = MarkerUnit::pixels;  // lengths: of the marker's frame
  uint32_t flags = 0;                          // MarkerFlags
  // Diameter of points; width of lines, axes and arrow shafts; font size (em) of texts. Solids and triangles
  // ignore it.
  float width = 1;
  // 0: until replaced or cleared. Else shown while the stream's shown frame has a simulator time from
  // sim_time_ns to sim_time_ns + lifetime_ns.
  uint64_t lifetime_ns = 0;
  int64_t sim_time_ns = 0;
  std::string parent;  // scene node; empty: the frame of the stream's poses
  Affine3x4 parent_from_marker;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 4>> rotations;  // x y z w; none, one for all, or one per position
  std::vector<std::array<float, 3>> sizes;      // full extents; one for all, or one per position
  // R | G << 8 | B << 16 | A << 24, sRGB, alpha not premultiplied; none (white), one for all, or one per
  // position.
  std::vector<uint32_t> colors;
  std::vector<std::string> texts;  // one per position of texts; no control characters but line feeds
  MarkerImage image;               // of images: left is at -x of an element, the top at +y
  bool operator==(const Marker&) const = default;
};

// Elements of such markers have rotations and sizes.
inline bool has_sizes(MarkerKind kind) {
  return (kind >= MarkerKind::axes && kind <= MarkerKind::capsules) || kind == MarkerKind::images;
}

}  // namespace fire3dv::wire

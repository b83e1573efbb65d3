// C entry points of markers.h. They check arguments and convert them to a scene edit.
#include "fire3dv/markers.h"

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "call.h"
#include "protocol/wire/limits.h"
#include "scene_edits.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
namespace wire = fire3dv::wire;

namespace {

static_assert(FIRE3DV_MARKER_IMAGES + 1 == wire::kMarkerKindCount);
static_assert(FIRE3DV_MARKER_CAPSULES == static_cast<int>(wire::MarkerKind::capsules));
static_assert(FIRE3DV_MARKER_LENGTHS == static_cast<int>(wire::MarkerUnit::lengths));
static_assert(FIRE3DV_MARKER_OVERLAID == wire::kMarkerOverlaid);

// Copies an array of the caller. Returns FIRE3DV_OK or an error code, after fail().
template <typename Element>
int copy(const char* field, const void* from, size_t count, std::vector<Element>& to) {
  const std::string name = std::string("marker.") + field;
  if ((from == nullptr) != (count == 0))
    return fail(FIRE3DV_ERROR_ARGUMENT, name + " and its count must be given together");
  if (count > wire::kMaxSceneEditBytes / sizeof(Element))
    return fail(FIRE3DV_ERROR_BUDGET,
                name + " has " + std::to_string(count) + " elements; no budget is above 256 MiB: send fewer");
  to.resize(count);
  if (count != 0) std::memcpy(to.data(), from, count * sizeof(Element));
  return FIRE3DV_OK;
}

int copy_texts(const fire3dv_marker& marker, std::vector<std::string>& to) {
  if ((marker.texts == nullptr) != (marker.text_count == 0))
    return fail(FIRE3DV_ERROR_ARGUMENT, "marker.texts and its count must be given together");
  if (marker.text_count > wire::kMaxMarkerTexts)
    return fail(FIRE3DV_ERROR_BUDGET, "marker.texts has " + std::to_string(marker.text_count) +
                                          " elements; at most " + std::to_string(wire::kMaxMarkerTexts) +
                                          " are allowed: use several markers");
  to.reserve(marker.text_count);
  for (size_t i = 0; i < marker.text_count; ++i) {
    if (!marker.texts[i])
      return fail(FIRE3DV_ERROR_ARGUMENT, "marker.texts[" + std::to_string(i) + "] is NULL");
    to.push_back(fire3dv::client::text_of(marker.texts[i], wire::kMaxMarkerTextBytes));
  }
  return FIRE3DV_OK;
}

// Sizes are checked first, so that no more bytes are read than a valid image has.
int copy_image(const fire3dv_marker& marker, wire::MarkerImage& to) {
  const bool has_numbers = marker.image_width != 0 || marker.image_height != 0 || marker.image_channels != 0;
  if ((marker.image_pixels != nullptr) != has_numbers)
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "marker.image_pixels, image_width, image_height and image_channels must be given together");
  if (!has_numbers) return FIRE3DV_OK;
  const auto is_side = [](uint32_t side) { return side >= 1 && side <= wire::kMaxMarkerImageSide; };
  if (!is_side(marker.image_width) || !is_side(marker.image_height))
    return fail(FIRE3DV_ERROR_ARGUMENT, "marker.image has " + std::to_string(marker.image_width) + " x " +
                                            std::to_string(marker.image_height) +
                                            " pixels; 1 to 1024 a side are allowed: scale it down");
  if (marker.image_channels != 1 && marker.image_channels != 3 && marker.image_channels != 4)
    return fail(FIRE3DV_ERROR_ARGUMENT, "marker.image_channels is " + std::to_string(marker.image_channels) +
                                            "; use 1 (grey), 3 (red, green, blue) or 4 (and alpha)");
  to.width = marker.image_width;
  to.height = marker.image_height;
  to.channels = static_cast<uint8_t>(marker.image_channels);
  to.pixels.assign(marker.image_pixels, marker.image_pixels + size_t{to.width} * to.height * to.channels);
  return FIRE3DV_OK;
}

int set_marker(fire3dv_stream* stream, const char* name, const fire3dv_marker* marker) {
  if (!stream) return fail(FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  if (!name) return fail(FIRE3DV_ERROR_ARGUMENT, "name is NULL");
  if (const char* problem = fire3dv::client::struct_error(
          marker, "marker is NULL", "marker.struct_size is not sizeof(fire3dv_marker); set it"))
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if (marker->kind < 0 || marker->kind >= static_cast<int>(wire::kMarkerKindCount))
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "marker.kind is " + std::to_string(marker->kind) + "; use FIRE3DV_MARKER_*");
  if (marker->width_unit != FIRE3DV_MARKER_PIXELS && marker->width_unit != FIRE3DV_MARKER_LENGTHS)
    return fail(FIRE3DV_ERROR_ARGUMENT, "marker.width_unit is " + std::to_string(marker->width_unit) +
                                            "; use FIRE3DV_MARKER_PIXELS or FIRE3DV_MARKER_LENGTHS");
  if ((marker->flags & ~FIRE3DV_MARKER_OVERLAID) != 0)
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "marker.flags is " + std::to_string(marker->flags) + "; use FIRE3DV_MARKER_OVERLAID or 0");
  wire::Marker value;
  value.kind = static_cast<wire::MarkerKind>(marker->kind);
  value.width_unit = static_cast<wire::MarkerUnit>(marker->width_unit);
  value.width = marker->width;
  value.flags = marker->flags;
  value.lifetime_ns = marker->lifetime_ns;
  if (marker->lifetime_ns != 0) value.sim_time_ns = stream->last_sim_time_ns;
  value.parent = fire3dv::client::text_of(marker->parent, fire3dv::client::outgoing_limits().max_name_bytes);
  if (marker->parent_from_marker)
    std::memcpy(value.parent_from_marker.m.data(), marker->parent_from_marker,
                sizeof value.parent_from_marker.m);
  if (int code = copy("positions", marker->positions, marker->position_count, value.positions)) return code;
  if (int code = copy("rotations", marker->rotations, marker->rotation_count, value.rotations)) return code;
  if (int code = copy("sizes", marker->sizes, marker->size_count, value.sizes)) return code;
  if (int code = copy_texts(*marker, value.texts)) return code;
  if (int code = copy_image(*marker, value.image)) return code;
  if (int code = copy("colors", marker->colors, marker->color_count, value.colors)) return code;
  return fire3dv::client::set_edit(stream, name, wire::Property::marker, std::move(value));
}

int clear_marker(fire3dv_stream* stream, const char* name) {
  if (!stream) return fail(FIRE3DV_ERROR_ARGUMENT, "stream is NULL");
  if (!name) return fail(FIRE3DV_ERROR_ARGUMENT, "name is NULL");
  return fire3dv::client::set_edit(stream, name, wire::Property::marker, wire::Cleared{});
}

}  // namespace

int fire3dv_set_marker(fire3dv_stream* stream, const char* name, const fire3dv_marker* marker) {
  return guarded(stream, [&] { return set_marker(stream, name, marker); });
}

int fire3dv_clear_marker(fire3dv_stream* stream, const char* name) {
  return guarded(stream, [&] { return clear_marker(stream, name); });
}

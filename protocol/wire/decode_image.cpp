#include "protocol/wire/decode_tables.h"

#include <cstring>

#include "fire3dv_generated.h"
#include "protocol/wire/check.h"

namespace fire3dv::wire {
namespace {

// Leaves the default if the struct is absent.
template <typename Struct, typename Array>
void read_struct(const Struct* from, Array& to) {
  static_assert(sizeof(Struct) == sizeof(Array));
  if (from) std::memcpy(&to, from, sizeof to);
}

std::string text_of(const flatbuffers::String* text) {
  return text ? std::string(text->c_str(), text->size()) : std::string();
}

template <typename Table>
Intrinsics read_intrinsics(const Table& table) {
  Intrinsics result;
  result.width = table.width();
  result.height = table.height();
  result.fx = table.fx();
  result.fy = table.fy();
  result.cx = table.cx();
  result.cy = table.cy();
  result.near_m = table.near_m();
  result.far_m = table.far_m();
  result.lens.model = static_cast<LensModel>(table.lens());
  read_struct(table.lens_coefficients(), result.lens.coefficients);
  return result;
}

}  // namespace

Result<Message> read_image_request(const fbs::ImageRequest& table, const DecodeLimits& limits) {
  ImageRequest request;
  request.epoch = table.epoch();
  request.id = table.id();
  request.place = table.place();
  request.node = text_of(table.node());
  read_struct(table.parent_from_camera(), request.parent_from_camera.m);
  request.intrinsics = read_intrinsics(table);
  request.outputs = table.outputs();
  request.when = static_cast<ImageWhen>(table.when());
  request.every = table.every();
  request.rate_hz = table.rate_hz();
  request.sequence = table.sequence();
  if (auto good = check(request, limits); !good) return good.error();
  return Message(std::move(request));
}

Result<Message> read_image_frame(const fbs::ImageFrame& table, const DecodeLimits& limits) {
  ImageFrame frame;
  frame.request = table.request();
  frame.number = table.number();
  frame.epoch = table.epoch();
  frame.sequence = table.sequence();
  frame.sim_time_ns = table.sim_time_ns();
  read_struct(table.world_from_camera(), frame.world_from_camera.m);
  frame.intrinsics = read_intrinsics(table);
  frame.pixel_bytes = table.pixel_bytes();
  if (const auto* planes = table.planes()) {
    // Skips outputs of later versions, which are unknown here.
    for (flatbuffers::uoffset_t i = 0; i < planes->size(); ++i) {
      // Copies the struct: the verifier does not check the alignment of a vector of structs.
      fbs::ImagePlane plane;
      std::memcpy(&plane, planes->Data() + i * sizeof plane, sizeof plane);
      if (plane.output() >= kImageOutputCount) continue;
      frame.planes.push_back({plane.output(), static_cast<ImageFormat>(plane.format()), plane.width(),
                              plane.height(), plane.row_stride(), plane.offset(), plane.bytes()});
      if (frame.planes.size() > kImageOutputCount) break;  // rejected by check(): a duplicate output
    }
  }
  if (auto good = check(frame, limits); !good) return good.error();
  return Message(std::move(frame));
}

Result<Message> read_image_refused(const fbs::ImageRefused& table, const DecodeLimits& limits) {
  ImageRefused refused;
  refused.epoch = table.epoch();
  refused.request = table.request();
  // Unknown reasons of later minor versions keep the default.
  const uint8_t reason = table.reason();
  if (reason >= 1 && reason <= kImageRefusalCount) refused.reason = static_cast<ImageRefusal>(reason);
  refused.message = text_of(table.message());
  if (auto good = check(refused, limits); !good) return good.error();
  return Message(std::move(refused));
}

}  // namespace fire3dv::wire

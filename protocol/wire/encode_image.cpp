// Encoding of image messages. Tables are built field by field, as in encode.cpp, so that the bytes do not
// depend on the flatc version.
#include <cstring>

#include "fire3dv_generated.h"
#include "protocol/wire/encode.h"

namespace fire3dv::wire {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

template <typename Struct, typename Array>
Struct as_struct(const Array& array) {
  static_assert(sizeof(Struct) == sizeof(Array));
  Struct result;
  std::memcpy(static_cast<void*>(&result), &array, sizeof result);
  return result;
}

template <typename Builder>
void add_intrinsics(Builder& table, const Intrinsics& camera, const fbs::Coefficients& coefficients) {
  table.add_lens_coefficients(&coefficients);
  table.add_far_m(camera.far_m);
  table.add_near_m(camera.near_m);
  table.add_cy(camera.cy);
  table.add_cx(camera.cx);
  table.add_fy(camera.fy);
  table.add_fx(camera.fx);
  table.add_height(camera.height);
  table.add_width(camera.width);
  table.add_lens(static_cast<uint8_t>(camera.lens.model));
}

Bytes finish(FlatBufferBuilder& builder, fbs::Body type, Offset<void> body) {
  fbs::MessageBuilder message(builder);
  message.add_body(body);
  message.add_body_type(type);
  builder.Finish(message.Finish(), fbs::MessageIdentifier());
  const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
  return Bytes(begin, begin + builder.GetSize());
}

}  // namespace

Bytes encode(const ImageRequest& request) {
  FlatBufferBuilder builder(512);
  builder.ForceDefaults(true);
  const auto node = builder.CreateString(request.node);
  const auto parent_from_camera = as_struct<fbs::Affine3x4>(request.parent_from_camera);
  const auto coefficients = as_struct<fbs::Coefficients>(request.intrinsics.lens.coefficients);
  fbs::ImageRequestBuilder table(builder);
  table.add_sequence(request.sequence);
  table.add_rate_hz(request.rate_hz);
  table.add_id(request.id);
  table.add_epoch(request.epoch);
  table.add_node(node);
  table.add_parent_from_camera(&parent_from_camera);
  table.add_place(request.place);
  table.add_outputs(request.outputs);
  table.add_every(request.every);
  add_intrinsics(table, request.intrinsics, coefficients);
  table.add_when(static_cast<uint8_t>(request.when));
  return finish(builder, fbs::Body::ImageRequest, table.Finish().Union());
}

Bytes encode(const ImageFrame& frame) {
  FlatBufferBuilder builder(1024);
  builder.ForceDefaults(true);
  std::vector<fbs::ImagePlane> planes;
  planes.reserve(frame.planes.size());
  for (const ImagePlane& plane : frame.planes)
    planes.emplace_back(static_cast<uint8_t>(plane.output_bit), static_cast<uint8_t>(plane.format),
                        plane.width, plane.height, plane.row_stride, plane.offset, plane.bytes);
  const auto plane_list = builder.CreateVectorOfStructs(planes.data(), planes.size());
  const auto world_from_camera = as_struct<fbs::Affine3x4>(frame.world_from_camera);
  const auto coefficients = as_struct<fbs::Coefficients>(frame.intrinsics.lens.coefficients);
  fbs::ImageFrameBuilder table(builder);
  table.add_pixel_bytes(frame.pixel_bytes);
  table.add_sim_time_ns(frame.sim_time_ns);
  table.add_sequence(frame.sequence);
  table.add_epoch(frame.epoch);
  table.add_number(frame.number);
  table.add_request(frame.request);
  table.add_planes(plane_list);
  table.add_world_from_camera(&world_from_camera);
  add_intrinsics(table, frame.intrinsics, coefficients);
  return finish(builder, fbs::Body::ImageFrame, table.Finish().Union());
}

Bytes encode(const ImageRefused& refused) {
  FlatBufferBuilder builder(512);
  builder.ForceDefaults(true);
  const auto message = builder.CreateString(refused.message);
  fbs::ImageRefusedBuilder table(builder);
  table.add_request(refused.request);
  table.add_epoch(refused.epoch);
  table.add_message(message);
  table.add_reason(static_cast<uint8_t>(refused.reason));
  return finish(builder, fbs::Body::ImageRefused, table.Finish().Union());
}

}  // namespace fire3dv::wire

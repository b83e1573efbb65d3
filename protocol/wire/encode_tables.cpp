// Encoding of scene edits, image messages and input events. Tables are built field by field, as in
// encode.cpp, so that the bytes do not depend on the flatc version.
#include <cstring>

#include "base/error.h"
#include "protocol/wire/encode_tables.h"

namespace fire3dv::wire {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

static_assert(sizeof(fbs::Vector3) == sizeof(std::array<float, 3>) &&
              sizeof(fbs::Rgba) == sizeof(std::array<float, 4>));

template <typename Struct, typename Array>
Struct as_struct(const Array& array) {
  static_assert(sizeof(Struct) == sizeof(Array));
  Struct result;
  std::memcpy(static_cast<void*>(&result), &array, sizeof result);
  return result;
}

Offset<flatbuffers::Vector<const fbs::Vector3*>> add_vectors(
    FlatBufferBuilder& builder, const std::vector<std::array<float, 3>>& vectors) {
  return builder.CreateVectorOfStructs(reinterpret_cast<const fbs::Vector3*>(vectors.data()), vectors.size());
}

// Absent where there is none, so that the bytes are those of 1.6.
template <typename Builder, typename Camera>
void add_lens(Builder& table, const Camera& camera) {
  if (camera.f_number == 0 && camera.focus_distance_m == 0) return;
  table.add_focus_distance_m(camera.focus_distance_m);
  table.add_f_number(camera.f_number);
}

struct Value {
  fbs::EditValue type;
  Offset<void> table;
};

Value add(FlatBufferBuilder& builder, const Cleared&) {
  return {fbs::EditValue::EditCleared, fbs::EditClearedBuilder(builder).Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Visible& value) {
  fbs::EditVisibleBuilder table(builder);
  table.add_visible(value.visible);
  return {fbs::EditValue::EditVisible, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const BaseColor& value) {
  const auto rgba = as_struct<fbs::Rgba>(value.rgba);
  fbs::EditBaseColorBuilder table(builder);
  table.add_rgba(&rgba);
  return {fbs::EditValue::EditBaseColor, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Light& value) {
  const auto color = as_struct<fbs::Vector3>(value.color_rgb);
  fbs::EditLightBuilder table(builder);
  table.add_outer_cone_rad(value.outer_cone_rad);
  table.add_inner_cone_rad(value.inner_cone_rad);
  table.add_range_m(value.range_m);
  table.add_intensity(value.intensity);
  table.add_color_rgb(&color);
  table.add_casts_shadow(value.casts_shadow);
  table.add_kind(static_cast<uint8_t>(value.kind));
  return {fbs::EditValue::EditLight, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Camera& value) {
  fbs::EditCameraBuilder table(builder);
  add_lens(table, value);
  table.add_exposure(value.exposure);
  table.add_far_m(value.far_m);
  table.add_near_m(value.near_m);
  table.add_vertical_fov_rad(value.vertical_fov_rad);
  return {fbs::EditValue::EditCamera, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const NodeAdded& value) {
  const auto parent_from_node = as_struct<fbs::Affine3x4>(value.parent_from_node);
  // Left out when empty: such a message is that of version 1.1, byte for byte.
  const auto variant = value.variant.empty() ? 0 : builder.CreateString(value.variant);
  const auto glb =
      builder.CreateVector(reinterpret_cast<const uint8_t*>(value.asset_glb.data()), value.asset_glb.size());
  const auto uri = builder.CreateString(value.asset_uri);
  const auto parent = builder.CreateString(value.parent);
  fbs::EditNodeAddedBuilder table(builder);
  if (!value.variant.empty()) table.add_variant(variant);
  table.add_asset_glb(glb);
  table.add_asset_uri(uri);
  table.add_parent_from_node(&parent_from_node);
  table.add_parent(parent);
  return {fbs::EditValue::EditNodeAdded, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const NodeRemoved&) {
  return {fbs::EditValue::EditNodeRemoved, fbs::EditNodeRemovedBuilder(builder).Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Vertices& value) {
  const auto normals = add_vectors(builder, value.normals);
  const auto positions = add_vectors(builder, value.positions);
  fbs::EditVerticesBuilder table(builder);
  table.add_normals(normals);
  table.add_positions(positions);
  return {fbs::EditValue::EditVertices, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Marker& value) {
  static_assert(sizeof(fbs::Quaternion) == sizeof value.rotations[0]);
  const auto parent_from_marker = as_struct<fbs::Affine3x4>(value.parent_from_marker);
  // Absent where there are none, so that the bytes of other markers are those of 1.4.
  const auto texts =
      value.texts.empty()
          ? flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<flatbuffers::String>>>()
          : builder.CreateVectorOfStrings(value.texts);
  const bool has_image = value.image != MarkerImage{};
  const auto pixels = has_image ? builder.CreateVector(value.image.pixels)
                                : flatbuffers::Offset<flatbuffers::Vector<uint8_t>>();
  const auto colors = builder.CreateVector(value.colors);
  const auto sizes = add_vectors(builder, value.sizes);
  const auto rotations = builder.CreateVectorOfStructs(
      reinterpret_cast<const fbs::Quaternion*>(value.rotations.data()), value.rotations.size());
  const auto positions = add_vectors(builder, value.positions);
  const auto parent = builder.CreateString(value.parent);
  fbs::EditMarkerBuilder table(builder);
  table.add_sim_time_ns(value.sim_time_ns);
  table.add_lifetime_ns(value.lifetime_ns);
  if (has_image) {
    table.add_image_pixels(pixels);
    table.add_image_height(value.image.height);
    table.add_image_width(value.image.width);
  }
  if (!value.texts.empty()) table.add_texts(texts);
  table.add_colors(colors);
  table.add_sizes(sizes);
  table.add_rotations(rotations);
  table.add_positions(positions);
  table.add_parent_from_marker(&parent_from_marker);
  table.add_parent(parent);
  table.add_width(value.width);
  table.add_flags(value.flags);
  if (has_image) table.add_image_channels(value.image.channels);
  table.add_width_unit(static_cast<uint8_t>(value.width_unit));
  table.add_kind(static_cast<uint8_t>(value.kind));
  return {fbs::EditValue::EditMarker, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Scalars& value) {
  const auto units = builder.CreateVectorOfStrings(value.units);
  const auto names = builder.CreateVectorOfStrings(value.names);
  fbs::EditScalarsBuilder table(builder);
  table.add_units(units);
  table.add_names(names);
  return {fbs::EditValue::EditScalars, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const ScalarValues& value) {
  const auto values = builder.CreateVector(value.values);
  fbs::EditScalarValuesBuilder table(builder);
  table.add_values(values);
  table.add_sim_time_ns(value.sim_time_ns);
  table.add_declaration(value.declaration);
  return {fbs::EditValue::EditScalarValues, table.Finish().Union()};
}

Value add(FlatBufferBuilder& builder, const Input& value) {
  const auto choices = builder.CreateVectorOfStrings(value.choices);
  const auto text = builder.CreateString(value.text);
  const auto unit = builder.CreateString(value.unit);
  fbs::EditInputBuilder table(builder);
  table.add_choices(choices);
  table.add_text(text);
  table.add_unit(unit);
  table.add_speed(value.speed);
  table.add_value(value.value);
  table.add_step(value.step);
  table.add_maximum(value.maximum);
  table.add_minimum(value.minimum);
  table.add_flags(value.flags);
  table.add_kind(static_cast<uint8_t>(value.kind));
  return {fbs::EditValue::EditInput, table.Finish().Union()};
}

// Size of the first allocation: a builder doubles its buffer, and copies it, whenever it is full.
size_t initial_bytes(const EditValue& value) {
  constexpr size_t kTables = 512;
  if (const auto* scalars = std::get_if<ScalarValues>(&value))
    return kTables + scalars->values.size() * sizeof scalars->values[0];
  const auto* marker = std::get_if<Marker>(&value);
  if (!marker) return kTables;
  return kTables + marker->positions.size() * sizeof marker->positions[0] +
         marker->rotations.size() * sizeof marker->rotations[0] +
         marker->sizes.size() * sizeof marker->sizes[0] + marker->colors.size() * sizeof marker->colors[0];
}

}  // namespace

Bytes encode(const SceneEdit& edit) {
  FlatBufferBuilder builder(initial_bytes(edit.value));
  builder.ForceDefaults(true);
  const Value value = std::visit([&](const auto& v) { return add(builder, v); }, edit.value);
  const auto node = builder.CreateString(edit.node);
  fbs::SceneEditBuilder table(builder);
  table.add_value(value.table);
  table.add_node(node);
  table.add_value_type(value.type);
  table.add_property(static_cast<uint8_t>(edit.property));
  table.add_version(edit.version);
  table.add_epoch(edit.epoch);
  return finish(builder, fbs::Body::SceneEdit, table.Finish().Union());
}

void set_epoch(Bytes& scene_edit, uint64_t epoch) {
  const fbs::SceneEdit* table = fbs::GetMessage(scene_edit.data())->body_as_SceneEdit();
  FIRE3DV_ASSERT(table != nullptr);
  const uint8_t* field =
      reinterpret_cast<const flatbuffers::Table*>(table)->GetAddressOf(fbs::SceneEdit::VT_EPOCH);
  FIRE3DV_ASSERT(field != nullptr);
  std::memcpy(scene_edit.data() + (field - reinterpret_cast<const uint8_t*>(scene_edit.data())), &epoch,
              sizeof epoch);
}

namespace {

template <typename Builder>
void add_intrinsics(Builder& table, const Intrinsics& camera, const fbs::Coefficients& coefficients) {
  add_lens(table, camera);
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

template <typename Struct, typename Value>
Offset<flatbuffers::Vector<const Struct*>> add_structs(FlatBufferBuilder& builder,
                                                       const std::vector<Value>& values) {
  static_assert(sizeof(Struct) == sizeof(Value));
  if (values.empty()) return 0;
  return builder.CreateVectorOfStructs(reinterpret_cast<const Struct*>(values.data()), values.size());
}

// Empty lists are absent.
Offset<fbs::ImageBatch> add_batch(FlatBufferBuilder& builder, const ImageBatch& batch) {
  const auto add = [&](const auto& numbers) {
    return numbers.empty() ? 0 : builder.CreateVector(numbers.data(), numbers.size());
  };
  const auto nodes = add(batch.node_indices);
  const auto poses = add_structs<fbs::Affine3x4>(builder, batch.poses);
  const auto world_of_view = add(batch.world_of_view);
  const auto view_poses = add_structs<fbs::Affine3x4>(builder, batch.view_poses);
  const auto view_projections = add_structs<fbs::Projection>(builder, batch.view_projections);
  const auto active = add(batch.active);
  fbs::ImageBatchBuilder table(builder);
  table.add_worlds(batch.worlds);
  if (!nodes.IsNull()) table.add_node_indices(nodes);
  if (!poses.IsNull()) table.add_poses(poses);
  if (!world_of_view.IsNull()) table.add_world_of_view(world_of_view);
  if (!view_poses.IsNull()) table.add_view_poses(view_poses);
  if (!view_projections.IsNull()) table.add_view_projections(view_projections);
  if (!active.IsNull()) table.add_active(active);
  return table.Finish();
}

}  // namespace

Bytes encode(const ImageRequest& request) {
  const size_t batch_bytes = request.batch ? request.batch->poses.size() * sizeof(Affine3x4) : 0;
  FlatBufferBuilder builder(512 + batch_bytes + batch_bytes / 4);
  builder.ForceDefaults(true);
  Offset<fbs::ImageBatch> batch;
  if (request.batch) batch = add_batch(builder, *request.batch);
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
  if (request.markers) table.add_markers(true);    // absent else: bytes as in 1.2
  if (request.complete) table.add_complete(true);  // the same
  if (request.batch) table.add_batch(batch);       // the same
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
  if (frame.hidden_streams != 0) table.add_hidden_streams(frame.hidden_streams);  // absent else: as in 1.7
  if (frame.views != 1) table.add_views(frame.views);                             // the same
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

Bytes encode(const InputEvent& event) {
  FlatBufferBuilder builder(512);
  builder.ForceDefaults(true);
  const auto text = builder.CreateString(event.text);
  const auto input = builder.CreateString(event.input);
  const auto node_point = as_struct<fbs::Vector3d>(event.node_point);
  const auto target = as_struct<fbs::Vector3d>(event.target);
  fbs::InputEventBuilder table(builder);
  table.add_target(&target);
  table.add_node_point(&node_point);
  table.add_value(event.value);
  table.add_sim_time_ns(event.sim_time_ns);
  table.add_time_ns(event.time_ns);
  table.add_sequence(event.sequence);
  table.add_source(event.source);
  table.add_epoch(event.epoch);
  table.add_text(text);
  table.add_input(input);
  table.add_node(event.node);
  table.add_viewer(event.viewer);
  table.add_action(static_cast<uint8_t>(event.action));
  return finish(builder, fbs::Body::InputEvent, table.Finish().Union());
}

}  // namespace fire3dv::wire

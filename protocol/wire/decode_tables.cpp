#include "protocol/wire/decode_tables.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "fire3dv_generated.h"
#include "protocol/wire/check.h"

namespace fire3dv::wire {
namespace {

std::string text_of(const flatbuffers::String* text) {
  return text ? std::string(text->c_str(), text->size()) : std::string();
}

// Leaves the default if the struct is absent.
template <typename Struct, typename Array>
void read_struct(const Struct* from, Array& to) {
  static_assert(sizeof(Struct) == sizeof(Array));
  if (from) std::memcpy(&to, from, sizeof to);
}

template <typename Element, typename Vector>
std::vector<Element> read_elements(const Vector* vectors) {
  static_assert(sizeof(std::remove_pointer_t<typename Vector::value_type>) == sizeof(Element));
  std::vector<Element> result;
  if (!vectors || vectors->size() == 0) return result;
  result.resize(vectors->size());
  std::memcpy(result.data(), vectors->Data(), result.size() * sizeof result[0]);
  return result;
}

std::vector<std::array<float, 3>> read_vectors(const flatbuffers::Vector<const fbs::Vector3*>* vectors) {
  return read_elements<std::array<float, 3>>(vectors);
}

Light read_light(const fbs::EditLight& table) {
  Light light;
  light.kind = static_cast<LightKind>(table.kind());
  read_struct(table.color_rgb(), light.color_rgb);
  light.intensity = table.intensity();
  light.range_m = table.range_m();
  light.inner_cone_rad = table.inner_cone_rad();
  light.outer_cone_rad = table.outer_cone_rad();
  light.casts_shadow = table.casts_shadow();
  return light;
}

NodeAdded read_node(const fbs::EditNodeAdded& table) {
  NodeAdded node;
  node.parent = text_of(table.parent());
  read_struct(table.parent_from_node(), node.parent_from_node.m);
  node.asset_uri = text_of(table.asset_uri());
  if (const auto* glb = table.asset_glb()) {
    const auto* begin = reinterpret_cast<const std::byte*>(glb->data());
    node.asset_glb.assign(begin, begin + glb->size());
  }
  node.variant = text_of(table.variant());
  return node;
}

// Elements may share one string, so that a small message has many bytes of text. Stops beyond the limits,
// which check() then reports.
void read_texts(const flatbuffers::Vector<flatbuffers::Offset<flatbuffers::String>>* from,
                std::vector<std::string>& to) {
  if (!from) return;
  size_t bytes = 0;
  for (const flatbuffers::String* text : *from) {
    if (to.size() > kMaxMarkerTexts || bytes > kMaxMarkerTextsBytes) return;
    to.push_back(text_of(text));
    bytes += to.back().size();
  }
}

Marker read_marker(const fbs::EditMarker& table) {
  Marker marker;
  marker.kind = static_cast<MarkerKind>(table.kind());
  marker.width_unit = static_cast<MarkerUnit>(table.width_unit());
  marker.flags = table.flags();
  marker.width = table.width();
  marker.lifetime_ns = table.lifetime_ns();
  marker.sim_time_ns = table.sim_time_ns();
  marker.parent = text_of(table.parent());
  read_struct(table.parent_from_marker(), marker.parent_from_marker.m);
  marker.positions = read_vectors(table.positions());
  marker.rotations = read_elements<std::array<float, 4>>(table.rotations());
  marker.sizes = read_vectors(table.sizes());
  marker.colors = read_elements<uint32_t>(table.colors());
  read_texts(table.texts(), marker.texts);
  marker.image = {table.image_width(), table.image_height(), table.image_channels(), {}};
  if (const auto* pixels = table.image_pixels())
    marker.image.pixels.assign(pixels->data(), pixels->data() + pixels->size());
  return marker;
}

using Strings = flatbuffers::Vector<flatbuffers::Offset<flatbuffers::String>>;

size_t bytes_of(const Strings* list) {
  size_t bytes = 0;
  if (list)
    for (const flatbuffers::String* text : *list) bytes += text->size();
  return bytes;
}

std::vector<std::string> read_strings(const Strings* list) {
  std::vector<std::string> result;
  if (!list) return result;
  result.reserve(list->size());
  for (const flatbuffers::String* text : *list) result.push_back(text_of(text));
  return result;
}

// Rejects what would expand to far more than the message: list entries may share one long string.
Result<void> check_size(const fbs::EditScalars& table, size_t message_bytes) {
  const size_t count = table.names() ? table.names()->size() : 0;
  if (count > kMaxScalars)
    return Error{"SceneEdit.names holds " + std::to_string(count) + " names; at most " +
                 std::to_string(kMaxScalars) + " scalars are allowed"};
  if (bytes_of(table.names()) > message_bytes)
    return Error{"SceneEdit.names is longer than the message that holds it: its names overlap"};
  const size_t units = table.units() ? table.units()->size() : 0;
  if (units > kMaxScalars)
    return Error{"SceneEdit.units holds " + std::to_string(units) + " units; one for each name is needed"};
  if (bytes_of(table.units()) > message_bytes)
    return Error{"SceneEdit.units is longer than the message that holds it: its units overlap"};
  return {};
}

// The same for the choices of an input. Longer texts than allowed are left to check().
Result<void> check_size(const fbs::EditInput& table, size_t message_bytes) {
  const size_t count = table.choices() ? table.choices()->size() : 0;
  if (count > kMaxInputChoices)
    return Error{"SceneEdit.choices holds " + std::to_string(count) + " texts; at most " +
                 std::to_string(kMaxInputChoices) + " are allowed"};
  if (bytes_of(table.choices()) > message_bytes)
    return Error{"SceneEdit.choices is longer than the message that holds it: its texts overlap"};
  return {};
}

Input read_input(const fbs::EditInput& table) {
  Input input;
  input.kind = static_cast<InputKind>(table.kind());
  input.flags = table.flags();
  input.minimum = table.minimum();
  input.maximum = table.maximum();
  input.step = table.step();
  input.value = table.value();
  input.speed = table.speed();
  input.unit = text_of(table.unit());
  input.text = text_of(table.text());
  input.choices = read_strings(table.choices());
  return input;
}

// Returns false for an unknown kind of a later version.
bool read_value(const fbs::SceneEdit& table, EditValue& value) {
  switch (table.value_type()) {
    case fbs::EditValue::NONE:
      return false;
    case fbs::EditValue::EditCleared:
      value = Cleared{};
      return true;
    case fbs::EditValue::EditVisible:
      value = Visible{table.value_as_EditVisible()->visible()};
      return true;
    case fbs::EditValue::EditBaseColor: {
      BaseColor color;
      read_struct(table.value_as_EditBaseColor()->rgba(), color.rgba);
      value = color;
      return true;
    }
    case fbs::EditValue::EditLight:
      value = read_light(*table.value_as_EditLight());
      return true;
    case fbs::EditValue::EditCamera: {
      const fbs::EditCamera& camera = *table.value_as_EditCamera();
      value = Camera{camera.vertical_fov_rad(), camera.near_m(),   camera.far_m(),
                     camera.exposure(),         camera.f_number(), camera.focus_distance_m()};
      return true;
    }
    case fbs::EditValue::EditNodeAdded:
      value = read_node(*table.value_as_EditNodeAdded());
      return true;
    case fbs::EditValue::EditNodeRemoved:
      value = NodeRemoved{};
      return true;
    case fbs::EditValue::EditVertices: {
      const fbs::EditVertices& vertices = *table.value_as_EditVertices();
      value = Vertices{read_vectors(vertices.positions()), read_vectors(vertices.normals())};
      return true;
    }
    case fbs::EditValue::EditMarker:
      value = read_marker(*table.value_as_EditMarker());
      return true;
    case fbs::EditValue::EditScalars: {
      const fbs::EditScalars& scalars = *table.value_as_EditScalars();
      value = Scalars{read_strings(scalars.names()), read_strings(scalars.units())};
      return true;
    }
    case fbs::EditValue::EditScalarValues: {
      const fbs::EditScalarValues& scalars = *table.value_as_EditScalarValues();
      value =
          ScalarValues{scalars.declaration(), scalars.sim_time_ns(), read_elements<double>(scalars.values())};
      return true;
    }
    case fbs::EditValue::EditInput:
      value = read_input(*table.value_as_EditInput());
      return true;
  }
  return false;
}

}  // namespace

Result<Message> read_scene_edit(const fbs::SceneEdit& table, size_t message_bytes,
                                const DecodeLimits& limits) {
  const fbs::EditInput* const input = table.value_as_EditInput();
  const bool known = table.property() < kPropertyCount && table.value_type() <= fbs::EditValue::MAX &&
                     !(input && input->kind() >= kInputKindCount);
  if (!known) {
    const UnknownEdit later{table.epoch(), table.version()};
    if (later.epoch == 0) return Error{"SceneEdit.epoch is 0; an epoch is a random number that is not 0"};
    if (later.version == 0) return Error{"SceneEdit.version is 0; versions start at 1"};
    return Message(later);
  }
  if (!table.value()) return Error{"SceneEdit.value is missing; to take an edit back, clear it"};
  if (const fbs::EditScalars* scalars = table.value_as_EditScalars())
    if (auto good = check_size(*scalars, message_bytes); !good) return good.error();
  if (input)
    if (auto good = check_size(*input, message_bytes); !good) return good.error();
  SceneEdit edit;
  edit.epoch = table.epoch();
  edit.version = table.version();
  edit.node = text_of(table.node());
  edit.property = static_cast<Property>(table.property());
  if (!read_value(table, edit.value))
    return Error{"SceneEdit.value is missing; to take an edit back, clear it"};
  if (auto good = check(edit, limits); !good) return good.error();
  return Message(std::move(edit));
}

namespace {

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
  result.f_number = table.f_number();
  result.focus_distance_m = table.focus_distance_m();
  return result;
}

ImageBatch read_batch(const fbs::ImageBatch& table) {
  ImageBatch batch;
  batch.worlds = table.worlds();
  batch.node_indices = read_elements<uint32_t>(table.node_indices());
  batch.poses = read_elements<Affine3x4>(table.poses());
  batch.world_of_view = read_elements<uint32_t>(table.world_of_view());
  batch.view_poses = read_elements<Affine3x4>(table.view_poses());
  batch.view_projections = read_elements<Projection>(table.view_projections());
  if (const auto* active = table.active())
    batch.active.assign(active->data(), active->data() + active->size());
  return batch;
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
  request.markers = table.markers();
  request.complete = table.complete();
  if (table.batch()) request.batch = read_batch(*table.batch());
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
  frame.hidden_streams = table.hidden_streams();
  frame.views = std::max(table.views(), 1u);  // absent: 1
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

Result<Message> read_input_event(const fbs::InputEvent& table, const DecodeLimits& limits) {
  if (table.action() >= kInputActionCount)
    return Message(UnknownMessage{static_cast<uint8_t>(fbs::Body::InputEvent)});
  InputEvent event;
  event.epoch = table.epoch();
  event.source = table.source();
  event.sequence = table.sequence();
  event.viewer = table.viewer();
  event.time_ns = table.time_ns();
  event.sim_time_ns = table.sim_time_ns();
  event.input = text_of(table.input());
  event.action = static_cast<InputAction>(table.action());
  event.value = table.value();
  event.text = text_of(table.text());
  event.node = table.node();
  read_struct(table.node_point(), event.node_point);
  read_struct(table.target(), event.target);
  if (auto good = check(event, limits); !good) return good.error();
  return Message(std::move(event));
}

}  // namespace fire3dv::wire

#include "protocol/wire/decode_tables.h"

#include <cstring>

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

std::vector<std::array<float, 3>> read_vectors(const flatbuffers::Vector<const fbs::Vector3*>* vectors) {
  std::vector<std::array<float, 3>> result;
  if (!vectors || vectors->size() == 0) return result;
  result.resize(vectors->size());
  std::memcpy(result.data(), vectors->Data(), result.size() * sizeof result[0]);
  return result;
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
  return node;
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
      value = Camera{camera.vertical_fov_rad(), camera.near_m(), camera.far_m(), camera.exposure()};
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
  }
  return false;
}

}  // namespace

Result<Message> read_scene_edit(const fbs::SceneEdit& table, const DecodeLimits& limits) {
  const bool known = table.property() < kPropertyCount && table.value_type() <= fbs::EditValue::MAX;
  if (!known) {
    const UnknownEdit later{table.epoch(), table.version()};
    if (later.epoch == 0) return Error{"SceneEdit.epoch is 0; an epoch is a random number that is not 0"};
    if (later.version == 0) return Error{"SceneEdit.version is 0; versions start at 1"};
    return Message(later);
  }
  if (!table.value()) return Error{"SceneEdit.value is missing; to take an edit back, clear it"};
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

}  // namespace fire3dv::wire

// C entry points of scene.h. They check arguments and convert them to a wire::SceneEdit; fire3dv_stream sends
// it.
#include "fire3dv/scene.h"

#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "call.h"
#include "protocol/wire/check.h"
#include "protocol/wire/limits.h"
#include "scene_edits.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::client::struct_error;
using fire3dv::client::text_of;
namespace wire = fire3dv::wire;

namespace {

static_assert(FIRE3DV_PROPERTY_MARKER + 4 == wire::kPropertyCount);  // scalars.h and input.h have the others
static_assert(FIRE3DV_PROPERTY_NODE == static_cast<int>(wire::Property::node));
static_assert(FIRE3DV_LIGHT_SPOT == static_cast<int>(wire::LightKind::spot));

int set(fire3dv_stream* stream, const char* node, wire::Property property, wire::EditValue value) {
  if (!node) return fail(FIRE3DV_ERROR_ARGUMENT, stream ? "node is NULL" : "stream is NULL");
  return fire3dv::client::set_edit(stream, node, property, std::move(value));
}

int set_light(fire3dv_stream* stream, const char* node, const fire3dv_light* light) {
  if (const char* problem =
          struct_error(light, "light is NULL", "light.struct_size is not sizeof(fire3dv_light); set it"))
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if (light->kind < FIRE3DV_LIGHT_DIRECTIONAL || light->kind > FIRE3DV_LIGHT_SPOT)
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "light.kind is " + std::to_string(light->kind) + "; use FIRE3DV_LIGHT_*");
  wire::Light value;
  value.kind = static_cast<wire::LightKind>(light->kind);
  value.color_rgb = {light->color_rgb[0], light->color_rgb[1], light->color_rgb[2]};
  value.intensity = light->intensity;
  value.range_m = light->range_m;
  value.inner_cone_rad = light->inner_cone_rad;
  value.outer_cone_rad = light->outer_cone_rad;
  value.casts_shadow = light->casts_shadow != 0;
  return set(stream, node, wire::Property::light, value);
}

int set_camera(fire3dv_stream* stream, const char* node, const fire3dv_camera* camera) {
  // Programs built before the lens was appended pass the size without it.
  const bool has_lens = camera && camera->struct_size != offsetof(fire3dv_camera, f_number);
  if (has_lens || !camera) {
    if (const char* problem = struct_error(camera, "camera is NULL",
                                           "camera.struct_size is not sizeof(fire3dv_camera); set it"))
      return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  }
  wire::Camera value{camera->vertical_fov_rad, camera->near_m, camera->far_m, camera->exposure};
  if (has_lens) {
    value.f_number = camera->f_number;
    value.focus_distance_m = camera->focus_distance_m;
  }
  return set(stream, node, wire::Property::camera, value);
}

int add_node(fire3dv_stream* stream, const char* node, const fire3dv_node* added) {
  // Programs built before `variant` was appended pass the size without it.
  constexpr size_t kSizeWithoutVariant = offsetof(fire3dv_node, variant);
  const bool has_variant = added && added->struct_size != kSizeWithoutVariant;
  if (const char* problem =
          has_variant || !added
              ? struct_error(added, "added is NULL", "node.struct_size is not sizeof(fire3dv_node); set it")
              : nullptr)
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if ((added->asset_glb == nullptr) != (added->asset_glb_bytes == 0))
    return fail(FIRE3DV_ERROR_ARGUMENT, "asset_glb and asset_glb_bytes must be given together");
  if (added->asset_glb_bytes > wire::kMaxSceneEditBytes)
    return fail(FIRE3DV_ERROR_BUDGET, "asset_glb_bytes is " + std::to_string(added->asset_glb_bytes) +
                                          "; no budget is above 256 MiB: name a file by asset_uri");
  const wire::DecodeLimits limits = fire3dv::client::outgoing_limits();
  wire::NodeAdded value;
  value.parent = text_of(added->parent, limits.max_name_bytes);
  value.asset_uri = text_of(added->asset_uri, limits.max_text_bytes);
  if (has_variant) value.variant = text_of(added->variant, limits.max_name_bytes);
  if (added->parent_from_node)
    std::memcpy(value.parent_from_node.m.data(), added->parent_from_node, sizeof value.parent_from_node.m);
  const auto* glb = static_cast<const std::byte*>(added->asset_glb);
  value.asset_glb.assign(glb, glb + added->asset_glb_bytes);
  return set(stream, node, wire::Property::node, std::move(value));
}

int set_vertices(fire3dv_stream* stream, const char* node, const fire3dv_vertices* vertices) {
  if (const char* problem = struct_error(vertices, "vertices is NULL",
                                         "vertices.struct_size is not sizeof(fire3dv_vertices); set it"))
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if (vertices->vertex_count == 0 || !vertices->positions)
    return fail(FIRE3DV_ERROR_ARGUMENT, "vertices.positions is NULL or empty; clear the property instead");
  wire::Vertices value;
  const size_t count = vertices->vertex_count;
  if (count > wire::kMaxSceneEditBytes / sizeof value.positions[0])
    return fail(FIRE3DV_ERROR_BUDGET, "vertices.vertex_count is " + std::to_string(count) +
                                          "; no budget is above 256 MiB: send fewer");
  value.positions.resize(count);
  std::memcpy(value.positions.data(), vertices->positions, count * sizeof value.positions[0]);
  if (vertices->normals) {
    value.normals.resize(count);
    std::memcpy(value.normals.data(), vertices->normals, count * sizeof value.normals[0]);
  }
  return set(stream, node, wire::Property::vertices, std::move(value));
}

}  // namespace

int fire3dv::client::set_edit(fire3dv_stream* stream, const char* name, wire::Property property,
                              wire::EditValue value) {
  const wire::DecodeLimits limits = outgoing_limits();
  wire::SceneEdit edit{1, 1, text_of(name, limits.max_name_bytes), property, std::move(value)};
  if (auto good = wire::check(edit, limits); !good) return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  auto prepared = stream->edits.prepare(std::move(edit));
  if (!prepared) return fail(FIRE3DV_ERROR_BUDGET, prepared.error().message);
  if (auto sent = stream->send_edit(std::move(*prepared)); !sent)
    return fail(FIRE3DV_ERROR_SYSTEM, sent.error().message);
  return FIRE3DV_OK;
}

int fire3dv_set_visible(fire3dv_stream* stream, const char* node, int visible) {
  return guarded(stream,
                 [&] { return set(stream, node, wire::Property::visible, wire::Visible{visible != 0}); });
}

int fire3dv_set_base_color(fire3dv_stream* stream, const char* node, const float rgba[4]) {
  if (!rgba) return fail(FIRE3DV_ERROR_ARGUMENT, "rgba is NULL");
  return guarded(stream, [&] {
    return set(stream, node, wire::Property::base_color,
               wire::BaseColor{{rgba[0], rgba[1], rgba[2], rgba[3]}});
  });
}

int fire3dv_set_light(fire3dv_stream* stream, const char* node, const fire3dv_light* light) {
  return guarded(stream, [&] { return set_light(stream, node, light); });
}

int fire3dv_set_camera(fire3dv_stream* stream, const char* node, const fire3dv_camera* camera) {
  return guarded(stream, [&] { return set_camera(stream, node, camera); });
}

int fire3dv_add_node(fire3dv_stream* stream, const char* node, const fire3dv_node* added) {
  return guarded(stream, [&] { return add_node(stream, node, added); });
}

int fire3dv_remove_node(fire3dv_stream* stream, const char* node) {
  return guarded(stream, [&] { return set(stream, node, wire::Property::node, wire::NodeRemoved{}); });
}

int fire3dv_set_vertices(fire3dv_stream* stream, const char* node, const fire3dv_vertices* vertices) {
  return guarded(stream, [&] { return set_vertices(stream, node, vertices); });
}

int fire3dv_clear(fire3dv_stream* stream, const char* node, int property) {
  if (property < 0 || property > FIRE3DV_PROPERTY_MARKER)
    return fail(FIRE3DV_ERROR_ARGUMENT, "property is not one of FIRE3DV_PROPERTY_*");
  return guarded(stream,
                 [&] { return set(stream, node, static_cast<wire::Property>(property), wire::Cleared{}); });
}

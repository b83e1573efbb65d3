#include "renderer/passes/resources/edit_uploader.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "renderer/passes/resources/scene_materials.h"
#include "renderer/passes/resources/sun_light.h"
#include "renderer/scene/model/vertices.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu_types::MaterialRecord;
using gpu_types::PartRecord;
using gpu_types::PrimitiveRecord;

// Offset of index and mask in a top-level instance, behind the transform that deform/transforms.comp writes.
constexpr VkDeviceSize kIndexAndMask = sizeof(VkTransformMatrixKHR);

const scene::Mesh* mesh_of(const scene::Scene& scene, uint32_t node) {
  const uint32_t mesh = scene.nodes[node].mesh;
  return mesh == scene::kNone ? nullptr : &scene.meshes[mesh];
}

// Writes vertices in the order of the GPU's arrays.
void write_vertices(gpu::Patches& patches, GpuScene& gpu_scene, const InstanceVertices& own,
                    const scene::Scene& scene, const scene::PosedVertices& posed) {
  std::vector<glm::vec3> positions;
  std::vector<scene::TangentFrame> frames;
  for (size_t i = 0; i < own.vertices.size(); ++i) {
    positions.push_back(posed.positions[own.mesh_vertices[i]]);
    frames.push_back(
        scene::packed_frame(posed.normals[own.mesh_vertices[i]], scene::tangent_of(scene, own.vertices[i])));
  }
  for (VertexBuffers& vertices : gpu_scene.vertices) {
    patches.write(vertices.positions, own.first_vertex * sizeof(glm::vec3),
                  std::span<const glm::vec3>(positions));
    patches.write(vertices.frames, own.first_vertex * sizeof(scene::TangentFrame),
                  std::span<const scene::TangentFrame>(frames));
  }
  const scene::Mesh& mesh = *mesh_of(scene, own.node);
  for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
    const VkDeviceSize primitive = gpu_scene.primitive_at(own.node, mesh.first_primitive + i);
    static_assert(offsetof(PrimitiveRecord, mesh_radius) ==
                  offsetof(PrimitiveRecord, mesh_center) + sizeof(glm::vec3));
    for (VertexBuffers& vertices : gpu_scene.vertices)
      patches.write(vertices.primitives,
                    primitive * sizeof(PrimitiveRecord) + offsetof(PrimitiveRecord, mesh_center),
                    posed.sphere);
  }
}

}  // namespace

EditUploader::Changed EditUploader::upload(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                           GpuScene& gpu_scene, const scene::Scene& scene,
                                           const scene::SceneEdits& edits) {
  if (revisions_ == edits.revisions()) return {};
  Change change{gpu_scene, scene, edits, {}};
  const bool materials = revisions_.materials != edits.revisions().materials;
  if (materials) {
    // Recorded first: nodes with colour edits copy these materials.
    upload_materials(change);
    upload_textures(change);
    std::exchange(change.patches, {}).record(recorder, staging);
  }
  if (revisions_.visible != edits.revisions().visible) upload_visibility(change);
  if (materials || revisions_.base_color != edits.revisions().base_color) upload_colors(change, materials);
  if (revisions_.light != edits.revisions().light) upload_lights(change);
  if (revisions_.vertices != edits.revisions().vertices) upload_vertices(change);
  revisions_ = edits.revisions();
  change.patches.record(recorder, staging);
  if (change.draws) gpu_scene.collect_draws(recorder, staging, scene);
  return change.changed;
}

// Hidden parts reuse the flags that exclude parts from drawing and shadows, so shaders need no extra test.
// Instances hidden from rays are detached from the transforms pass, which would show them again.
void EditUploader::upload_visibility(Change& change) {
  GpuScene& gpu_scene = change.gpu_scene;
  const scene::Scene& scene = change.scene;
  gpu_scene.has_forward_only = false;
  for (uint32_t node = 0; node < gpu_scene.node_count; ++node) {
    const scene::Mesh* const mesh = mesh_of(scene, node);
    if (!mesh) continue;
    const bool hidden = change.edits.is_hidden(node), was_hidden = gpu_scene.is_hidden(node);
    const uint32_t first_part = gpu_scene.first_part_of_node[node];
    for (uint32_t part = first_part; part < first_part + mesh->primitive_count; ++part) {
      const uint32_t flags = gpu_scene.part_flags[part];
      if (!hidden) gpu_scene.has_forward_only |= (flags & FIRE3DV_PART_FORWARD_ONLY) != 0;
      if (hidden == was_hidden) continue;
      change.patches.write(gpu_scene.parts, part * sizeof(PartRecord) + offsetof(PartRecord, flags),
                           hidden ? flags | FIRE3DV_PART_FORWARD_ONLY | FIRE3DV_PART_NO_SHADOW : flags);
    }
    const uint32_t instance =
        gpu_scene.instance_at_node.empty() ? FIRE3DV_NO_INDEX : gpu_scene.instance_at_node[node];
    if (hidden == was_hidden || instance == FIRE3DV_NO_INDEX) continue;
    const bool moves = !hidden && transform_index_of(scene, node) == node;
    change.patches.write(gpu_scene.instance_of_node, node * sizeof(uint32_t),
                         moves ? instance : FIRE3DV_NO_INDEX);
    for (uint32_t world = 0; world < gpu_scene.world_count; ++world)
      change.patches.write(gpu_scene.instances,
                           world * gpu_scene.instance_bytes +
                               instance * sizeof(VkAccelerationStructureInstanceKHR) + kIndexAndMask,
                           (node & 0xffffffu) | (hidden ? 0 : 0xff000000u));
  }
  gpu_scene.hidden = change.edits.hidden();
  change.draws = change.changed.visibility = true;
}

// The factors come first in a record; no other data depends on them.
void EditUploader::upload_materials(Change& change) {
  const scene::MaterialEdits before = std::exchange(materials_, change.edits.materials());
  const auto write = [&](uint32_t number, const scene::MaterialFactors& factors) {
    const scene::Material edited = scene::with_factors(change.scene.materials[number], factors);
    const MaterialRecord record = material_records(std::span(&edited, 1)).materials[0];
    static_assert(offsetof(MaterialRecord, base_color) == 0 &&
                  offsetof(MaterialRecord, alpha_cutoff) + sizeof(float) == sizeof(scene::MaterialFactors));
    change.patches.write(change.gpu_scene.materials, number * sizeof(MaterialRecord),
                         std::as_bytes(std::span(&record, 1)).first(sizeof(scene::MaterialFactors)));
  };
  const size_t count = change.scene.materials.size();
  for (const auto& [number, factors] : before) {
    if (number < count && !materials_.contains(number))
      write(number, scene::factors_of(change.scene.materials[number]));
  }
  for (const auto& [number, factors] : materials_) {
    const auto old = before.find(number);
    if (number < count && (old == before.end() || old->second != factors)) write(number, factors);
  }
}

void EditUploader::upload_textures(Change& change) {
  if (textures_ == change.edits.textures()) return;
  const scene::MaterialTextureEdits before = std::exchange(textures_, change.edits.textures());
  const TextureFacts facts = texture_facts(change.scene, change.gpu_scene.filters_anisotropically);
  const auto write = [&](uint32_t number, const scene::MaterialTextures& textures) {
    const scene::Material edited = scene::with_textures(change.scene.materials[number], textures);
    const MaterialRecord record = material_records(std::span(&edited, 1), facts).materials[0];
    const VkDeviceSize at = number * sizeof(MaterialRecord);
    const auto write_use = [&](size_t offset, const gpu_types::TextureUse& use) {
      change.patches.write(change.gpu_scene.materials, at + offset, use);
    };
    write_use(offsetof(MaterialRecord, base_color_texture), record.base_color_texture);
    write_use(offsetof(MaterialRecord, normal_texture), record.normal_texture);
    write_use(offsetof(MaterialRecord, metallic_roughness_texture), record.metallic_roughness_texture);
  };
  const size_t count = change.scene.materials.size();
  for (const auto& [number, textures] : before) {
    if (number < count && !textures_.contains(number)) write(number, {});
  }
  for (const auto& [number, textures] : textures_) {
    const auto old = before.find(number);
    if (number < count && (old == before.end() || old->second != textures)) write(number, textures);
  }
}

void EditUploader::upload_colors(Change& change, bool recreate) {
  std::map<uint32_t, Color> wanted;
  for (const auto& [node, edit] : change.edits.nodes()) {
    if (edit.base_color && mesh_of(change.scene, node)) wanted[node] = {*edit.base_color};
  }
  const bool same_nodes = std::equal(wanted.begin(), wanted.end(), colors_.begin(), colors_.end(),
                                     [](const auto& a, const auto& b) { return a.first == b.first; });
  if (!same_nodes || (recreate && !wanted.empty())) {
    const std::map<uint32_t, Color> before = std::exchange(colors_, std::move(wanted));
    reserve_colors(change);
    for (const auto& [node, color] : before) {
      if (!colors_.contains(node)) restore_materials(change, node);
    }
    assign_edited_materials(change);
    return;
  }
  for (auto& [node, color] : colors_) {
    const glm::vec4 base_color = wanted[node].base_color;
    if (base_color == color.base_color) continue;
    color.base_color = base_color;
    for (uint32_t i = 0; i < mesh_of(change.scene, node)->primitive_count; ++i) {
      change.patches.write(
          change.gpu_scene.materials,
          (color.first_material + i) * sizeof(MaterialRecord) + offsetof(MaterialRecord, base_color),
          base_color);
    }
  }
}

// Copies of materials and primitives for nodes with colour edits are appended to the scene's arrays. Deformed
// nodes already have their own primitives.
void EditUploader::reserve_colors(Change& change) {
  GpuScene& gpu_scene = change.gpu_scene;
  const scene::Scene& scene = change.scene;
  uint32_t materials = gpu_scene.scene_material_count, primitives = gpu_scene.scene_primitive_count;
  for (auto& [node, color] : colors_) {
    const uint32_t count = mesh_of(scene, node)->primitive_count;
    color.first_material = materials;
    materials += count;
    if (!scene::is_deformed(scene.nodes[node])) primitives += count;
  }
  change.patches.reserve(device_, gpu_scene.materials,
                         gpu_scene.scene_material_count * sizeof(MaterialRecord),
                         materials * sizeof(MaterialRecord));
  for (VertexBuffers& vertices : gpu_scene.vertices)
    change.patches.reserve(device_, vertices.primitives,
                           gpu_scene.scene_primitive_count * sizeof(PrimitiveRecord),
                           primitives * sizeof(PrimitiveRecord));
}

void EditUploader::assign_edited_materials(Change& change) {
  GpuScene& gpu_scene = change.gpu_scene;
  const scene::Scene& scene = change.scene;
  gpu_scene.geometry.resize(gpu_scene.scene_primitive_count);
  for (const auto& [node, color] : colors_) {
    const scene::Mesh& mesh = *mesh_of(scene, node);
    const auto first_copy = static_cast<uint32_t>(gpu_scene.geometry.size());
    for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
      // The edited factor, then the rest of the source material.
      const VkDeviceSize source =
          scene.primitives[mesh.first_primitive + i].material * sizeof(MaterialRecord);
      const VkDeviceSize copy = (color.first_material + i) * sizeof(MaterialRecord);
      static_assert(offsetof(MaterialRecord, base_color) == 0);
      change.patches.write(gpu_scene.materials, copy, color.base_color);
      change.patches.copy(gpu_scene.materials, source + sizeof(glm::vec4), copy + sizeof(glm::vec4),
                          sizeof(MaterialRecord) - sizeof(glm::vec4));
      set_part_material(change, node, i, color.first_material + i);
      if (scene::is_deformed(scene.nodes[node])) {
        const uint32_t primitive = gpu_scene.primitive_at(node, mesh.first_primitive + i);
        write_primitives(change, primitive * sizeof(PrimitiveRecord) + offsetof(PrimitiveRecord, material),
                         color.first_material + i);
        continue;
      }
      gpu_scene.geometry.push_back(gpu_scene.geometry[mesh.first_primitive + i]);
      PrimitiveRecord record = primitive_record(scene, mesh, gpu_scene.geometry.back(), i);
      record.material = color.first_material + i;
      write_primitives(change, (first_copy + i) * sizeof(PrimitiveRecord), record);
    }
    if (!scene::is_deformed(scene.nodes[node])) set_first_primitive(change, node, first_copy);
  }
}

void EditUploader::restore_materials(Change& change, uint32_t node) {
  const scene::Mesh& mesh = *mesh_of(change.scene, node);
  for (uint32_t i = 0; i < mesh.primitive_count; ++i)
    set_part_material(change, node, i, change.scene.primitives[mesh.first_primitive + i].material);
  if (!scene::is_deformed(change.scene.nodes[node])) {
    set_first_primitive(change, node, mesh.first_primitive);
    return;
  }
  for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
    const uint32_t p = mesh.first_primitive + i;
    write_primitives(change,
                     change.gpu_scene.primitive_at(node, p) * sizeof(PrimitiveRecord) +
                         offsetof(PrimitiveRecord, material),
                     change.scene.primitives[p].material);
  }
}

void EditUploader::set_part_material(Change& change, uint32_t node, uint32_t i, uint32_t material) {
  const VkDeviceSize part = (change.gpu_scene.first_part_of_node[node] + i) * sizeof(PartRecord);
  change.patches.write(change.gpu_scene.parts, part + offsetof(PartRecord, material), material);
}

void EditUploader::set_first_primitive(Change& change, uint32_t node, uint32_t first_primitive) {
  GpuScene& gpu_scene = change.gpu_scene;
  const scene::Mesh& mesh = *mesh_of(change.scene, node);
  change.draws = true;
  gpu_scene.primitive_shift_of_node[node] = first_primitive - mesh.first_primitive;
  change.patches.write(gpu_scene.first_primitive_of_node, node * sizeof(uint32_t), first_primitive);
  for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
    const VkDeviceSize part = (gpu_scene.first_part_of_node[node] + i) * sizeof(PartRecord);
    change.patches.write(gpu_scene.parts, part + offsetof(PartRecord, primitive), first_primitive + i);
  }
}

void EditUploader::upload_lights(Change& change) {
  GpuScene& gpu_scene = change.gpu_scene;
  const std::vector<scene::PlacedLight> lights =
      drawn_lights(change.scene, &change.edits, added_lights(gpu_scene));
  std::vector<gpu_types::LightRecord> records;
  std::vector<uint32_t> light_at_node(gpu_scene.node_count, FIRE3DV_NO_INDEX);
  for (const scene::PlacedLight& placed : lights) {
    if (placed.node != scene::kNone) light_at_node[placed.node] = static_cast<uint32_t>(records.size());
    records.push_back(light_record(placed.light, placed.node));
  }
  change.patches.reserve(device_, gpu_scene.lights, 0, records.size() * sizeof(gpu_types::LightRecord));
  change.patches.write(gpu_scene.lights, 0, std::span<const gpu_types::LightRecord>(records));
  for (uint32_t node = 0; node < gpu_scene.node_count; ++node) {
    if (light_at_node[node] == gpu_scene.light_at_node[node]) continue;
    change.patches.write(gpu_scene.light_of_node, node * sizeof(uint32_t), light_at_node[node]);
  }
  gpu_scene.light_at_node = std::move(light_at_node);
  gpu_scene.light_count = static_cast<uint32_t>(lights.size());
  // The light poses follow the node transforms in the buffer.
  gpu_scene.light_bytes = lights.size() * sizeof(gpu_types::LightPose);
  change.patches.reserve(device_, gpu_scene.world_from_node, gpu_scene.light_poses_offset(),
                         gpu_scene.light_poses_offset() + gpu_scene.world_count * gpu_scene.light_bytes);
  change.changed.lights = true;
}

// Writes into the vertex copies of these nodes. Reverted nodes return to their rest vertices.
void EditUploader::upload_vertices(Change& change) {
  for (const InstanceVertices& own : change.gpu_scene.instance_vertices) {
    const auto edit = change.edits.nodes().find(own.node);
    std::shared_ptr<const scene::ReplacedVertices> wanted;
    if (edit != change.edits.nodes().end()) wanted = edit->second.vertices;
    std::shared_ptr<const scene::ReplacedVertices>& shown = vertices_[own.node];
    if (wanted == shown) continue;
    const scene::Mesh& mesh = *mesh_of(change.scene, own.node);
    write_vertices(change.patches, change.gpu_scene, own, change.scene,
                   wanted ? scene::pose_vertices(change.scene, mesh, *wanted)
                          : scene::rest_vertices(change.scene, mesh));
    shown = std::move(wanted);
    change.changed.vertices = true;
  }
}

}  // namespace fire3dv::passes

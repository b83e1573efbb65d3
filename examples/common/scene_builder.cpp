#include "examples/common/scene_builder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "examples/common/materials.h"
#include "examples/common/mesh.h"

namespace examples {

std::vector<Part> object_parts(const Object& object) {
  const Size& s = object.size;
  switch (object.shape) {
    case Shape::box: {
      const float least = std::min({s.x, s.y, s.z});
      return {{box_mesh({s.x, s.y, s.z}, std::min(0.22f * least, 0.006f)), object.material}};
    }
    case Shape::sphere:
      return {{capsule_mesh(s.x, 0, 48), object.material}};
    case Shape::capsule:
      return {{capsule_mesh(s.x, s.z), object.material}};
    case Shape::cylinder:
      break;
  }
  Part body{cylinder_mesh(s.x, s.z, std::min(0.12f * s.x, 0.2f * s.z)), object.material};
  if (object.mass_kg <= 0) return {body};
  // Can: a metal cylinder with a label sleeve half a millimetre thick.
  body.material = "brushed_metal";
  const bool teal = object.material == "painted_teal";
  return {body, {cylinder_mesh(s.x + 0.0005f, s.z * 0.74f, 0.0004f), teal ? "painted_teal" : "plastic_red"}};
}

namespace {

// Pose of a node at `eye` that looks along its -Z at `target`, +Y up.
GltfMatrix looking(Vec3 eye, Vec3 target) {
  const Vec3 at = y_up(eye);
  const Vec3 back = normalized(at - y_up(target));
  const Vec3 right = normalized(cross({0, 1, 0}, back));
  const Vec3 up = cross(back, right);
  return {right.x, up.x, back.x, at.x, right.y, up.y, back.y, at.y, right.z, up.z, back.z, at.z};
}

// Adds textures for base colour, metallic-roughness and normal, and returns the index of the first.
std::optional<size_t> add_surface(GltfWriter& writer, const std::string& name, const SurfaceImages& images) {
  const auto color = encode_png(images.base_color), rough = encode_png(images.metallic_roughness),
             normal = encode_png(images.normal);
  if (!color || !rough || !normal) return std::nullopt;
  const size_t first = writer.add_texture(name + "_base_color", *color);
  writer.add_texture(name + "_metallic_roughness", *rough);
  writer.add_texture(name + "_normal", *normal);
  return first;
}

}  // namespace

// world_from_stream * stream_from_body * body_from_node, expanded for the constants of mesh.h.
GltfMatrix rest_pose(const float* p) {
  return {p[0],  p[2],  -p[1], p[3],   //
          p[8],  p[10], -p[9], p[11],  //
          -p[4], -p[6], p[5],  -p[7]};
}

std::optional<std::string> SceneBuilder::add_materials() {
  const auto floor = add_surface(writer_, "floor", make_floor_images(1024));
  const auto wood = add_surface(writer_, "wood", make_wood_images(512));
  if (!floor || !wood) return "the scene's textures could not be encoded: libpng refused";
  for (const Material& material : make_materials()) {
    GltfMaterial out{material.name,
                     material.base_color,
                     material.metallic,
                     material.roughness,
                     material.emissive,
                     {},
                     {},
                     {}};
    float uv_scale = 1;
    if (material.surface != Surface::plain) {
      const bool is_floor = material.surface == Surface::floor;
      const size_t first = is_floor ? *floor : *wood;
      out.base_color_texture = first;
      out.metallic_roughness_texture = first + 1;
      out.normal_texture = first + 2;
      uv_scale = 1 / (is_floor ? kFloorTile_m : kWoodTile_m);
    }
    materials_[material.name] = {writer_.add_material(out), uv_scale};
  }
  return std::nullopt;
}

size_t SceneBuilder::add_mesh(const std::string& name, const std::vector<Part>& parts) {
  std::vector<Mesh> meshes;
  for (const Part& part : parts) meshes.push_back(y_up(part.mesh));
  std::vector<GltfWriter::Primitive> primitives;
  for (size_t i = 0; i < parts.size(); ++i) {
    const MaterialUse& use = materials_.at(parts[i].material);
    primitives.push_back({&meshes[i], use.index, use.uv_scale});
  }
  return writer_.add_mesh(name, primitives);
}

size_t SceneBuilder::object_mesh(const Object& object) {
  const auto key = std::make_tuple(object.shape, object.size.x, object.size.y, object.size.z, object.material,
                                   object.mass_kg > 0);
  const auto found = shared_.find(key);
  if (found != shared_.end()) return found->second;
  return shared_[key] = add_mesh(object.name, object_parts(object));
}

void SceneBuilder::add_body(const std::string& name, const GltfMatrix& world_from_node, size_t mesh) {
  writer_.add_node({name, world_from_node, mesh, {}, {}});
}

void SceneBuilder::add_light(const GltfLight& light, Vec3 at, Vec3 target) {
  const size_t index = writer_.add_light(light);
  writer_.add_node({light.name, looking(at, target), {}, {}, index});
}

void SceneBuilder::add_camera(const std::string& name, float vertical_fov_rad, Vec3 at, Vec3 target) {
  const size_t camera = writer_.add_camera(name, vertical_fov_rad, 0.01f);
  writer_.add_node({name, looking(at, target), {}, camera, {}});
}

std::optional<std::string> SceneBuilder::save(const std::string& path, const std::string& example) const {
  const std::vector<std::byte> bytes = writer_.finish(example, "FIRE-3DV " + example + " example");
  // Complete or nothing: a full disk leaves neither a cut file nor the loss of an earlier one.
  std::error_code ignored;
  const bool is_special =
      std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored);
  const std::string part = is_special ? path : path + ".part";
  std::FILE* file = std::fopen(part.c_str(), "wb");
  if (file == nullptr)
    return "cannot write " + path + ": " + std::strerror(errno) + "; name a file in a folder you own";
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int reason = errno;
  const bool closed = std::fclose(file) == 0;
  const int last_reason = errno;
  if (written && closed && (is_special || std::rename(part.c_str(), path.c_str()) == 0)) return std::nullopt;
  const int failure = !written ? reason : !closed ? last_reason : errno;
  if (!is_special) std::remove(part.c_str());
  return "cannot write all of " + path + ": " + std::strerror(failure);
}

}  // namespace examples

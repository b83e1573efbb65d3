#include "examples/bullet_arm/scene_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <tuple>

#include "examples/bullet_arm/arm.h"
#include "examples/bullet_arm/frames.h"
#include "examples/bullet_arm/glb_writer.h"
#include "examples/bullet_arm/materials.h"
#include "examples/bullet_arm/shapes.h"
#include "examples/bullet_arm/textures.h"

namespace bullet_arm {
namespace {

struct MaterialUse {
  size_t index = 0;
  float uv_scale = 1;
};

// world_from_node of a body whose stream_from_body is given: W * P * B, written out for the constants of
// frames.h.
GlbMatrix rest_pose(const float* p) {
  return {p[0],  p[2],  -p[1], p[3],   //
          p[8],  p[10], -p[9], p[11],  //
          -p[4], -p[6], p[5],  -p[7]};
}

// A node at eye that looks along its -Z at target, Y towards the sky; both in the stream's frame.
GlbMatrix looking(Vec3 eye, Vec3 target) {
  const Vec3 at = y_up(eye);
  const Vec3 back = normalized(at - y_up(target));
  const Vec3 right = normalized(cross({0, 1, 0}, back));
  const Vec3 up = cross(back, right);
  return {right.x, up.x, back.x, at.x, right.y, up.y, back.y, at.y, right.z, up.z, back.z, at.z};
}

class SceneBuilder {
 public:
  bool add_materials() {
    const auto floor = add_surface("floor", make_floor_images(1024));
    const auto wood = add_surface("wood", make_wood_images(512));
    if (!floor || !wood) return false;
    for (const Material& material : make_materials()) {
      GlbMaterial out{material.name,
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
    return true;
  }

  size_t add_mesh(const std::string& name, const std::vector<Part>& parts) {
    std::vector<Mesh> meshes;
    for (const Part& part : parts) meshes.push_back(y_up(part.mesh));
    std::vector<GlbWriter::Primitive> primitives;
    for (size_t i = 0; i < parts.size(); ++i) {
      const MaterialUse& use = materials_.at(parts[i].material);
      primitives.push_back({&meshes[i], use.index, use.uv_scale});
    }
    return writer_.add_mesh(name, primitives);
  }

  // Objects of one shape, size and material share a mesh.
  size_t object_mesh(const Object& object) {
    const auto key = std::make_tuple(object.shape, object.size.x, object.size.y, object.size.z,
                                     object.material, object.mass_kg > 0);
    const auto found = shared_.find(key);
    if (found != shared_.end()) return found->second;
    return shared_[key] = add_mesh(object.name, object_parts(object));
  }

  void add_bodies(const Simulation& simulation) {
    for (size_t i = 0; i < kArmNames.size(); ++i) {
      writer_.add_node({kArmNames[i],
                        rest_pose(&simulation.poses()[i * 12]),
                        add_mesh(kArmNames[i], arm_parts(i)),
                        {},
                        {}});
    }
    size_t streamed = kArmNames.size();
    for (const Object& object : simulation.layout()) {
      GlbMatrix pose;
      if (object.mass_kg > 0) {
        pose = rest_pose(&simulation.poses()[streamed++ * 12]);
      } else {
        std::array<float, 12> fixed;
        for (int row = 0; row < 3; ++row) {
          const auto at = static_cast<size_t>(row) * 4;
          for (int column = 0; column < 3; ++column) {
            fixed[at + static_cast<size_t>(column)] =
                static_cast<float>(object.stream_from_body.getBasis()[row][column]);
          }
          fixed[at + 3] = static_cast<float>(object.stream_from_body.getOrigin()[row]);
        }
        pose = rest_pose(fixed.data());
      }
      writer_.add_node({object.name, pose, object_mesh(object), {}, {}});
    }
  }

  void add_surroundings() {
    writer_.add_node({"floor",
                      GlbMatrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                      add_mesh("floor", {{floor_mesh(5), "floor"}}),
                      {},
                      {}});
    writer_.add_node({"backdrop",
                      GlbMatrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                      add_mesh("backdrop", {{backdrop_mesh(4.2f, 1.9f, 1.0f), "backdrop"}}),
                      {},
                      {}});

    // The spot is a warm key light from the left of the audience, the other a cool fill from the right.
    const size_t key = writer_.add_light({"key_light", "spot", {1.0f, 0.93f, 0.82f}, 130, 0.34f, 0.56f});
    const size_t fill = writer_.add_light({"fill_light", "directional", {0.72f, 0.84f, 1.0f}, 1.7f});
    writer_.add_node({"key_light", looking({-1.5f, -1.9f, 2.7f}, {0, -0.35f, 0.1f}), {}, {}, key});
    writer_.add_node({"fill_light", looking({0.35f, -1.8f, 2.0f}, {0, 0, 0}), {}, {}, fill});

    add_camera("camera_front", 0.72f, {0.45f, -2.15f, 1.20f}, {0.06f, -0.28f, 0.22f});
    add_camera("camera_gripper", 0.78f, {-1.28f, -0.98f, 0.52f}, {-0.40f, -0.38f, 0.12f});
    add_camera("camera_side", 0.75f, {1.75f, -1.05f, 0.75f}, {0.22f, -0.32f, 0.20f});
  }

  std::vector<uint8_t> finish() const { return writer_.finish("bullet_arm", "FIRE-3DV bullet_arm example"); }

 private:
  // The index of the first of three textures: colour, metallic-roughness, normal.
  std::optional<size_t> add_surface(const std::string& name, const SurfaceImages& images) {
    const auto color = encode_png(images.base_color), rough = encode_png(images.metallic_roughness),
               normal = encode_png(images.normal);
    if (!color || !rough || !normal) return std::nullopt;
    const size_t first = writer_.add_texture(name + "_base_color", *color);
    writer_.add_texture(name + "_metallic_roughness", *rough);
    writer_.add_texture(name + "_normal", *normal);
    return first;
  }

  void add_camera(const std::string& name, float vertical_fov_rad, Vec3 eye, Vec3 target) {
    const size_t camera = writer_.add_camera(name, vertical_fov_rad, 0.01f);
    writer_.add_node({name, looking(eye, target), {}, camera, {}});
  }

  GlbWriter writer_;
  std::map<std::string, MaterialUse> materials_;
  std::map<std::tuple<Shape, float, float, float, std::string, bool>, size_t> shared_;
};

}  // namespace

std::optional<std::string> write_scene(const Simulation& simulation, const std::string& path) {
  SceneBuilder builder;
  if (!builder.add_materials()) return "the scene's textures could not be encoded: libpng refused";
  builder.add_bodies(simulation);
  builder.add_surroundings();
  const std::vector<uint8_t> bytes = builder.finish();
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr)
    return "cannot write " + path + ": " + std::strerror(errno) + "; name a file in a folder you own";
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int reason = errno;
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed)
    return "cannot write all of " + path + ": " + std::strerror(written ? errno : reason);
  return std::nullopt;
}

}  // namespace bullet_arm

// Fuzz target of the ADF reader (AMBF description files): arbitrary bytes are refused with a message, or give
// a consistent model.
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "convert/readers.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

// Temporary file of this process, removed at its end.
struct File {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("fire3dv-adf-fuzz-" + std::to_string(getpid()) + ".yaml");
  ~File() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

bool is_one_line(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  return !text.empty();
}

void check(const convert::Model& model) {
  std::set<std::string> names;
  for (size_t i = 0; i < model.nodes.size(); ++i) {
    const convert::Node& node = model.nodes[i];
    FIRE3DV_ASSERT(names.insert(node.name).second && is_one_line(node.name));
    FIRE3DV_ASSERT(!node.parent || *node.parent < i);
    FIRE3DV_ASSERT(!node.mesh || *node.mesh < model.meshes.size());
    FIRE3DV_ASSERT(!node.camera || *node.camera < model.cameras.size());
    FIRE3DV_ASSERT(!node.light || *node.light < model.lights.size());
    for (int k = 0; k < 3; ++k) FIRE3DV_ASSERT(std::isfinite(node.translation[k]));
    FIRE3DV_ASSERT(std::abs(glm::length(node.rotation) - 1) < 1e-6);
  }
  for (const convert::Mesh& mesh : model.meshes) {
    for (const convert::Surface& surface : mesh.surfaces) {
      FIRE3DV_ASSERT(surface.material < model.materials.size());
      for (const uint32_t index : surface.indices) FIRE3DV_ASSERT(index < surface.positions.size());
      for (const glm::vec3& p : surface.positions)
        FIRE3DV_ASSERT(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      for (const glm::vec3& n : surface.normals) FIRE3DV_ASSERT(std::abs(glm::length(n) - 1) < 1e-3f);
    }
  }
  for (const convert::Light& light : model.lights)
    FIRE3DV_ASSERT(light.intensity > 0 && std::isfinite(light.intensity) &&
                   light.inner_cone_rad < light.outer_cone_rad && light.outer_cone_rad < 1.5708f);
  for (const convert::Camera& camera : model.cameras)
    FIRE3DV_ASSERT(camera.vertical_fov_rad > 0 && camera.near_m > 0 && *camera.far_m > camera.near_m);
  for (const std::string& warning : model.warnings) FIRE3DV_ASSERT(is_one_line(warning));
}

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  const std::filesystem::path scene = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/assets/adf";
  for (const char* name : {"launch.yaml", "world/world.yaml", "world/floor.yaml", "models/shapes.yaml",
                           "models/parts.yaml", "models/ghosts.yaml"}) {
    std::ifstream file(scene / name, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  static const fuzz::File file;
  std::ofstream(file.path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  const Result<convert::Model> model = convert::read_adf(file.path, {});
  if (model)
    fuzz::check(*model);
  else
    FIRE3DV_ASSERT(fuzz::is_one_line(model.error().message));
  return 0;
}

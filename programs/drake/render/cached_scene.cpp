#include "programs/drake/render/cached_scene.h"

#include <atomic>
#include <charconv>
#include <utility>

#include "renderer/camera/default_look.h"
#include "renderer/gpu/device/device.h"
#include "renderer/scene/derived/key_light.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/bounds.h"

namespace fire3dv::drake {
namespace {

constexpr Rgb8 kDontCare{255, 255, 255};

uint32_t index_named(const std::string& name) {
  uint32_t index = scene::kNone;
  std::from_chars(name.data(), name.data() + name.size(), index);
  return index;
}

}  // namespace

Result<std::unique_ptr<LoadedDrakeScene>> load_scene(GltfScene& gltf, const SceneLoading& loading) {
  std::atomic<uint64_t> reserved = 0;
  scene::LoadLimits limits;
  limits.max_file_bytes = loading.max_bytes;
  limits.max_decoded_image_bytes = loading.max_image_bytes;
  limits.stop_requested = loading.stop_requested;
  limits.reserve = [&](uint64_t bytes) -> Result<void> {
    if (bytes <= loading.max_bytes && reserved.fetch_add(bytes) + bytes <= loading.max_bytes) return {};
    return Error{"it takes more than " + std::to_string(loading.max_bytes >> 20) +
                 " MiB when it is loaded: simplify meshes and textures, or raise --max-scene"};
  };
  Result<scene::Scene> scene = scene::load_glb(gltf.take_glb(), "the scene", limits);
  if (!scene) return scene.error();
  auto result = std::make_unique<LoadedDrakeScene>();
  for (const scene::Node& node : scene->nodes) {
    // Instances have no name; they keep their place below their node.
    const uint32_t source = node.name.empty() ? scene::kNone : index_named(node.name);
    result->source_of_node.push_back(source);
    uint32_t label_source = source;
    if (source == scene::kNone && node.parent != scene::kNone)
      label_source = result->label_source_of_node[node.parent];
    result->label_source_of_node.push_back(label_source);
  }
  if (loading.has_key_light) scene::add_key_light(*scene);
  result->source_of_node.resize(scene->nodes.size(), scene::kNone);
  result->label_source_of_node.resize(scene->nodes.size(), scene::kNone);
  result->loaded.derived = scene::derive(*scene, loading.levels);
  result->loaded.scene = std::move(*scene);
  result->bytes = reserved + gltf.bytes();
  return result;
}

CachedScene::CachedScene(gpu::Device& device, const settings::DrawSettings& settings,
                         std::unique_ptr<LoadedDrakeScene> scene,
                         std::optional<settings::PostSettings> estimated)
    : scene_(std::move(scene)),
      settings_(settings),
      estimated_(std::move(estimated)),
      poses_(scene_->loaded.scene),
      rest_(state::rest_pose(scene_->loaded.scene)),
      renderer_(device, settings) {
  renderer_.set_scene(scene_->loaded.scene, scene_->loaded.derived);
}

void CachedScene::set_transforms(const GltfScene& gltf) {
  std::vector<scene::Node>& nodes = scene_->loaded.scene.nodes;
  // World transforms in double precision: chains of nodes would add up rounding errors.
  std::vector<glm::dmat4> world_from_node(nodes.size());
  for (size_t n = 0; n < nodes.size(); ++n) {
    const uint32_t source = scene_->source_of_node[n];
    const glm::dmat4 local =
        source == scene::kNone ? glm::dmat4(nodes[n].parent_from_node) : gltf.parent_from_node()[source];
    world_from_node[n] = nodes[n].parent == scene::kNone ? local : world_from_node[nodes[n].parent] * local;
    rest_.parent_from_node[n] = glm::mat4(local);
    rest_.world_from_node[n] = glm::mat4(world_from_node[n]);
    nodes[n].parent_from_node = rest_.parent_from_node[n];
    nodes[n].world_from_node = rest_.world_from_node[n];
  }
  poses_.set_rest(rest_);
  scene::Scene& scene = scene_->loaded.scene;
  scene.bounds_min = scene.bounds_max = {};
  scene::find_world_bounds(scene);  // for shadows and the estimated exposure
  if (!estimated_) return;
  const float before = settings_.post.exposure;
  (void)app::set_exposure(*estimated_, scene, settings_);
  if (settings_.post.exposure != before) renderer_.apply(settings_);
}

Rgb8 CachedScene::label_of(uint32_t node, const GltfScene& gltf) const {
  if (node >= scene_->label_source_of_node.size()) return kDontCare;
  const uint32_t source = scene_->label_source_of_node[node];
  return source < gltf.label_of_node().size() ? gltf.label_of_node()[source] : kDontCare;
}

}  // namespace fire3dv::drake

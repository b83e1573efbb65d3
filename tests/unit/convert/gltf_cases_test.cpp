// Test of glTF files that other programs were reported to read wrongly: each glTF row of cases/cases.txt
// gives its shapes, texture coordinates and texels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/unit/convert/cases_table.h"

namespace fire3dv::scene {
namespace {

std::vector<double> numbers_in(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

// Transforms a vertex to the world at rest.
glm::vec3 posed(const Scene& scene, const Node& node, const Primitive& primitive, uint32_t vertex) {
  const glm::vec4 position(scene.positions[primitive.first_vertex + vertex], 1);
  if (node.skin == kNone || primitive.influence_sets == 0) return node.world_from_node * position;
  glm::vec4 sum(0);
  for (uint32_t set = 0; set < primitive.influence_sets; ++set) {
    const Influences& of =
        scene.influences[primitive.first_influence + vertex * primitive.influence_sets + set];
    for (size_t i = 0; i < 4; ++i) {
      const Joint& joint = scene.joints[scene.skins[node.skin].first_joint + of.joints[i]];
      sum += of.weights[i] * (scene.nodes[joint.node].world_from_node * joint.joint_from_mesh * position);
    }
  }
  return sum;
}

// True for the node of this name and those below it, such as its instances; for all without a name.
bool is_below(const Scene& scene, const Node& node, const std::string& name) {
  for (const Node* at = &node;; at = &scene.nodes[at->parent]) {
    if (name.empty() || at->name == name) return true;
    if (at->parent == kNone) return false;
  }
}

// Calls visit(node, primitive) for the nodes that is_below() accepts.
template <typename Visit>
void for_each_primitive(const Scene& scene, const std::string& name, Visit&& visit) {
  for (const Node& node : scene.nodes) {
    if (node.mesh == kNone || !is_below(scene, node, name)) continue;
    const Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = 0; p < mesh.primitive_count; ++p)
      visit(node, scene.primitives[mesh.first_primitive + p]);
  }
}

struct Shape {
  size_t triangles = 0;
  double area = 0;
  glm::dvec3 low{1e9}, high{-1e9};
};

Shape shape_of(const Scene& scene, const std::string& name) {
  Shape shape;
  for_each_primitive(scene, name, [&](const Node& node, const Primitive& primitive) {
    shape.triangles += primitive.index_count / 3;
    for (uint32_t i = 0; i < primitive.index_count; i += 3) {
      glm::dvec3 corners[3];
      for (uint32_t k = 0; k < 3; ++k) {
        corners[k] = posed(scene, node, primitive, scene.indices[primitive.first_index + i + k]);
        shape.low = glm::min(shape.low, corners[k]);
        shape.high = glm::max(shape.high, corners[k]);
      }
      shape.area += glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0])) / 2;
    }
  });
  return shape;
}

std::vector<double> placed_uvs(const Scene& scene, const Primitive& primitive) {
  const TextureRef& texture = scene.materials[primitive.material].base_color_texture;
  std::vector<double> numbers;
  for (const uint32_t i : {0u, 1u, 2u, 5u}) {  // of a quad's triangles
    const uint32_t vertex = primitive.first_vertex + scene.indices.at(primitive.first_index + i);
    const glm::dvec2 uv(texture.uv_set == 1 ? scene.extras.at(vertex).uv1 : scene.uvs.at(vertex));
    const glm::dvec2 scaled = uv * glm::dvec2(texture.uv_scale);
    const double c = std::cos(texture.uv_rotation_rad), s = std::sin(texture.uv_rotation_rad);
    numbers.push_back(texture.uv_offset.x + c * scaled.x + s * scaled.y);
    numbers.push_back(texture.uv_offset.y - s * scaled.x + c * scaled.y);
  }
  return numbers;
}

std::string texels_of(const Scene& scene, const Primitive& primitive) {
  const Texture& texture = scene.textures[scene.materials[primitive.material].base_color_texture.texture];
  const Image& image = scene.images[texture.image];
  std::string text;
  for (size_t i = 0; i < size_t{image.width} * image.height; ++i) {
    char pixel[16];
    const auto* at = reinterpret_cast<const uint8_t*>(image.rgba8.data()) + 4 * i;
    std::snprintf(pixel, sizeof pixel, "%s%02x%02x%02x%02x", i > 0 ? "," : "", at[0], at[1], at[2], at[3]);
    text += pixel;
  }
  return text;
}

std::string wraps_of(const Scene& scene, const Primitive& primitive) {
  const Sampler& sampler =
      scene.textures[scene.materials[primitive.material].base_color_texture.texture].sampler;
  const auto name = [](scene::Wrap wrap) {
    return wrap == scene::Wrap::repeat ? "repeat" : wrap == scene::Wrap::mirrored_repeat ? "mirror" : "clamp";
  };
  return std::string(name(sampler.wrap_u)) + "," + name(sampler.wrap_v);
}

void expect_property(const Scene& scene, const std::string& key, const std::string& value) {
  SCOPED_TRACE(key + "=" + value);
  const size_t at = std::min(key.find('@'), key.size());
  const std::string property = key.substr(0, at), name = at == key.size() ? "" : key.substr(at + 1);
  const auto expect_all = [&](const std::vector<double>& is) {
    const std::vector<double> right = numbers_in(value);
    ASSERT_EQ(is.size(), right.size());
    for (size_t i = 0; i < is.size(); ++i) EXPECT_NEAR(is[i], right[i], 1e-4) << "number " << i;
  };
  const Shape shape = shape_of(scene, name);
  ASSERT_GT(shape.triangles, 0u);
  if (property == "area") return expect_all({shape.area});
  if (property == "box")
    return expect_all({shape.low.x, shape.low.y, shape.low.z, shape.high.x, shape.high.y, shape.high.z});
  for_each_primitive(scene, name, [&](const Node&, const Primitive& primitive) {
    constexpr const char* kModes[] = {"opaque", "mask", "blend"};
    if (property == "uvs") {
      expect_all(placed_uvs(scene, primitive));
    } else if (property == "texels") {
      EXPECT_EQ(texels_of(scene, primitive), value);
    } else if (property == "wrap") {
      EXPECT_EQ(wraps_of(scene, primitive), value);
    } else if (property == "mode") {
      EXPECT_EQ(kModes[static_cast<size_t>(scene.materials[primitive.material].alpha_mode)], value);
    } else {
      ADD_FAILURE() << "unknown property";
    }
  });
}

TEST(GltfCases, EachFileIsLoadedAsItsRowSays) {
  size_t rows = 0;
  std::map<std::string, Result<Scene>> scenes;
  for (const test::CaseRow& row : test::case_rows()) {
    if (!row.is_gltf()) continue;
    SCOPED_TRACE(row.line);
    ++rows;
    auto known = scenes.find(row.file);
    if (known == scenes.end())
      known = scenes.emplace(row.file, load_gltf(test::cases_folder() / row.file)).first;
    const Result<Scene>& scene = known->second;
    if (row.triangles == "!") {
      ASSERT_FALSE(scene.ok());
      EXPECT_NE(scene.error().message.find(row.warning), std::string::npos) << scene.error().message;
      continue;
    }
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const Shape shape = shape_of(*scene, "");
    EXPECT_EQ(std::to_string(shape.triangles), row.triangles);
    for (int i = 0; i < 6; ++i) {
      if (row.corners[i] == "-") continue;
      const double is = i < 3 ? shape.low[i] : shape.high[i - 3];
      EXPECT_NEAR(is, std::strtod(row.corners[i].c_str(), nullptr), 1e-5) << "corner number " << i;
    }
    for (const auto& [key, value] : row.properties) expect_property(*scene, key, value);
    EXPECT_EQ(row.warning, "-");
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
  }
  EXPECT_GE(rows, 30u);
}

}  // namespace
}  // namespace fire3dv::scene

// Test of descriptions as they are found in public repositories: each file of cases/cases.txt gives the
// shapes and the warning of its row.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/unit/convert/cases_table.h"

namespace fire3dv::convert {
namespace {

struct Drawn {
  size_t triangles = 0;
  double area = 0, volume = 0;  // the latter is negative for bodies that are inside out
  glm::dvec3 low{1e9}, high{-1e9};
};

Drawn drawn_by(const Model& model) {
  Drawn drawn;
  std::vector<glm::dmat4> poses;
  for (const Node& node : model.nodes) {
    glm::dmat4 pose = glm::mat4_cast(node.rotation);
    pose[3] = glm::dvec4(node.translation, 1);
    if (node.parent) pose = poses[*node.parent] * pose;
    poses.push_back(pose);
    if (!node.mesh) continue;
    for (const Surface& surface : model.meshes[*node.mesh].surfaces) {
      drawn.triangles += surface.indices.size() / 3;
      for (const glm::vec3& position : surface.positions) {
        const glm::dvec3 at(pose * glm::dvec4(position, 1));
        drawn.low = glm::min(drawn.low, at);
        drawn.high = glm::max(drawn.high, at);
      }
      for (size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
        glm::dvec3 corners[3];
        for (size_t k = 0; k < 3; ++k)
          corners[k] = pose * glm::dvec4(surface.positions[surface.indices[i + k]], 1);
        drawn.volume += glm::dot(corners[0], glm::cross(corners[1], corners[2])) / 6;
        drawn.area += glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0])) / 2;
      }
    }
  }
  return drawn;
}

std::vector<double> numbers_of(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

// Surfaces of what is drawn whose node or material has this name; all for an empty one.
std::vector<const Surface*> surfaces_of(const Model& model, const std::string& name) {
  std::vector<const Surface*> surfaces;
  for (const Node& node : model.nodes) {
    if (!node.mesh) continue;
    for (const Surface& surface : model.meshes[*node.mesh].surfaces)
      if (name.empty() || node.name == name || model.materials[surface.material].name == name)
        surfaces.push_back(&surface);
  }
  return surfaces;
}

// Largest texture coordinates less the smallest.
glm::vec2 uv_span(const std::vector<const Surface*>& surfaces) {
  glm::vec2 low(1e9f), high(-1e9f);
  for (const Surface* surface : surfaces) {
    for (const glm::vec2& uv : surface->uvs) {
      low = glm::min(low, uv);
      high = glm::max(high, uv);
    }
  }
  return high - low;
}

void expect_near(const std::vector<double>& is, const std::vector<double>& right, double tolerance) {
  ASSERT_EQ(is.size(), right.size());
  for (size_t i = 0; i < is.size(); ++i) EXPECT_NEAR(is[i], right[i], tolerance) << "number " << i;
}

void expect_property(const Model& model, const Drawn& drawn, const std::string& key,
                     const std::string& value) {
  SCOPED_TRACE(key + "=" + value);
  if (key == "area" || key == "volume") {
    EXPECT_NEAR(key == "area" ? drawn.area : drawn.volume, std::strtod(value.c_str(), nullptr), 1e-4);
    return;
  }
  const size_t at = std::min(key.find('@'), key.size());
  const std::string property = key.substr(0, at);
  const auto surfaces = surfaces_of(model, at == key.size() ? "" : key.substr(at + 1));
  ASSERT_FALSE(surfaces.empty());
  if (property == "span") {
    const glm::vec2 span = uv_span(surfaces);
    expect_near({span.x, span.y}, numbers_of(value), 1e-4);
    return;
  }
  for (const Surface* surface : surfaces) {
    const Material* m = &model.materials[surface->material];
    const ImagePlacement& placement = m->base_color_placement;
    constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};
    if (property == "rgb") {
      const std::vector<double> displayed = numbers_of(value);
      ASSERT_EQ(displayed.size(), 3u);
      const glm::vec3 right = linear_from_srgb(glm::vec3(displayed[0], displayed[1], displayed[2]));
      EXPECT_LT(glm::length(glm::vec3(m->base_color) - right), 2e-3f) << m->name << ' ' << m->base_color.r;
    } else if (property == "alpha") {
      EXPECT_NEAR(m->base_color.a, std::strtod(value.c_str(), nullptr), 1e-4) << m->name;
      if (m->base_color.a < 1) {
        EXPECT_TRUE(m->blended) << m->name;
      }
    } else if (property == "metal") {
      EXPECT_NEAR(m->metallic, std::strtod(value.c_str(), nullptr), 1e-4) << m->name;
    } else if (property == "linear") {
      const std::vector<double> color = numbers_of(value);
      expect_near({m->base_color.r, m->base_color.g, m->base_color.b}, color, 1e-4);
    } else if (property == "mode") {
      EXPECT_EQ(m->alpha_cutoff ? "mask" : m->blended ? "blend" : "opaque", value) << m->name;
    } else if (property == "uv") {
      expect_near({placement.scale.x, placement.scale.y, placement.offset.x, placement.offset.y},
                  numbers_of(value), 1e-5);
    } else if (property == "wrap") {
      EXPECT_EQ(kWraps[static_cast<size_t>(placement.wrap_u)], value);
    } else if (property == "image") {
      std::string name = m->base_color_image ? model.images[*m->base_color_image].name : "none";
      std::replace(name.begin(), name.end(), ' ', '_');
      EXPECT_EQ(name, value) << m->name;
    } else {
      ADD_FAILURE() << "unknown property";
    }
  }
}

TEST(DescriptionCases, FilesMatchTheirRows) {
  const std::filesystem::path folder = test::cases_folder();
  size_t rows = 0;
  std::map<std::string, Result<Model>> models;
  for (const test::CaseRow& row : test::case_rows()) {
    if (row.is_gltf()) continue;
    const std::string &name = row.file, &triangles = row.triangles;
    const auto& corners = row.corners;
    SCOPED_TRACE(row.line);
    ++rows;
    const bool is_sdf = name.ends_with(".sdf") || name.ends_with(".world");
    auto known = models.find(name);
    const bool is_new = known == models.end();
    if (is_new) known = models.emplace(name, read_description(folder / name, {})).first;
    const Result<Model>& model = known->second;
    if (!model && is_sdf && model.error().message.find("libsdformat") != std::string::npos) continue;
    ASSERT_TRUE(model.ok()) << model.error().message;
    const Drawn drawn = drawn_by(*model);
    if (triangles != "-") {
      EXPECT_EQ(std::to_string(drawn.triangles), triangles);
    }
    for (int i = 0; i < 6; ++i) {
      if (corners[i] == "-") continue;
      const double is = i < 3 ? drawn.low[i] : drawn.high[i - 3];
      EXPECT_NEAR(is, std::strtod(corners[i].c_str(), nullptr), 1e-5) << (i < 3 ? "low " : "high ") << i % 3;
    }
    for (const auto& [key, value] : row.properties) expect_property(*model, drawn, key, value);
    std::string warnings;
    for (const std::string& each : model->warnings) warnings += each + "\n";
    if (row.warning == "-") {
      EXPECT_EQ(warnings, "");
    } else {
      EXPECT_NE(warnings.find(row.warning), std::string::npos) << warnings;
    }
    if (!is_new) continue;
    // Far planes of 0 are no valid glTF.
    const Result<std::vector<std::byte>> glb = write_glb(*model);
    ASSERT_TRUE(glb.ok()) << glb.error().message;
    const std::string text(reinterpret_cast<const char*>(glb->data()), glb->size());
    EXPECT_EQ(text.find("\"zfar\":0"), std::string::npos);
    EXPECT_TRUE(scene::load_glb(*glb, name).ok());
  }
  EXPECT_GE(rows, 85u);
}

TEST(DescriptionCases, ConfinedModelsReadNothingOutside) {
  ReadOptions options;
  options.is_confined = true;
  const std::filesystem::path folder = test::cases_folder();
  EXPECT_FALSE(read_description(folder / "mjcf_parent/scene/task.xml", options).ok());
  const Result<Model> robot = read_description(folder / "mjcf_parent/scene/robot.xml", options);
  ASSERT_TRUE(robot.ok());
  EXPECT_EQ(drawn_by(*robot).triangles, 12u);
  options.package_folders = {folder / "mjcf_parent"};
  EXPECT_TRUE(read_description(folder / "mjcf_parent/scene/task.xml", options).ok());
}

TEST(DescriptionCases, GltfUpIsAnOption) {
  ReadOptions options;
  options.gltf_up = false;
  const std::filesystem::path folder = test::cases_folder();
  const Result<Model> model = read_description(folder / "gltf_up.urdf", options);
  ASSERT_TRUE(model.ok());
  EXPECT_NEAR(drawn_by(*model).high.y, 1, 1e-5);
}

}  // namespace
}  // namespace fire3dv::convert

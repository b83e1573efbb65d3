// Test of descriptions as they are found in public repositories: each file of cases/cases.txt gives the
// shapes and the warning of its row.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::convert {
namespace {

struct Drawn {
  size_t triangles = 0;
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
    }
  }
  return drawn;
}

TEST(DescriptionCases, EachFileIsDrawnAsItsRowSays) {
  const std::filesystem::path folder = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/unit/convert/cases";
  std::ifstream table(folder / "cases.txt");
  ASSERT_TRUE(table.is_open());
  size_t rows = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream columns(line);
    std::string name, triangles, warning;
    std::string corners[6];
    columns >> name >> triangles;
    for (std::string& corner : corners) columns >> corner;
    std::getline(columns >> std::ws, warning);
    SCOPED_TRACE(line);
    ++rows;
    const bool is_sdf = name.ends_with(".sdf") || name.ends_with(".world");
    const Result<Model> model = read_description(folder / name, {});
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
    std::string warnings;
    for (const std::string& each : model->warnings) warnings += each + "\n";
    if (warning == "-") {
      EXPECT_EQ(warnings, "");
    } else {
      EXPECT_NE(warnings.find(warning), std::string::npos) << warnings;
    }
    // Far planes of 0 are no valid glTF.
    const Result<std::vector<std::byte>> glb = write_glb(*model);
    ASSERT_TRUE(glb.ok()) << glb.error().message;
    const std::string text(reinterpret_cast<const char*>(glb->data()), glb->size());
    EXPECT_EQ(text.find("\"zfar\":0"), std::string::npos);
    EXPECT_TRUE(scene::load_glb(*glb, name).ok());
  }
  EXPECT_GE(rows, 18u);
}

TEST(DescriptionCases, ConfinedModelsReadNothingOutside) {
  ReadOptions options;
  options.is_confined = true;
  const std::filesystem::path folder = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/unit/convert/cases";
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
  const std::filesystem::path folder = std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/unit/convert/cases";
  const Result<Model> model = read_description(folder / "gltf_up.urdf", options);
  ASSERT_TRUE(model.ok());
  EXPECT_NEAR(drawn_by(*model).high.y, 1, 1e-5);
}

}  // namespace
}  // namespace fire3dv::convert

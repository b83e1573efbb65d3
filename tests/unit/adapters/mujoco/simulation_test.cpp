// Test of the MuJoCo adapter: poses equal mjData, node names equal the converted scene's. A fatal MuJoCo
// error ends only the call.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/adapters/mujoco/models.h"

namespace fire3dv::mujoco {
namespace {

namespace fs = std::filesystem;

// Models of this tree, and robots of the asset collection if available.
std::vector<fs::path> models() {
  std::vector<fs::path> found{in_tree(kCrane), in_tree("tests/assets/robots/arm.xml")};
  const char* const named = std::getenv("FIRE3DV_ASSETS");
  const fs::path assets = named ? fs::path(named) : fs::path(FIRE3DV_SOURCE_DIR) / "../shared/assets";
  for (const char* robot : {"franka_emika_panda/scene.xml", "robotiq_2f85/scene.xml"})
    if (fs::exists(assets / "robots" / robot)) found.push_back(assets / "robots" / robot);
  return found;
}

void run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Result<void> done = simulation.step();
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  ASSERT_TRUE(simulation.update_poses().ok());
}

glm::dmat4 matrix_at(const mjtNum* position, const mjtNum* rows) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix[column][row] = rows[3 * row + column];
    matrix[3][row] = position[row];
  }
  return matrix;
}

TEST(MujocoAdapter, PosesMatchMjData) {
  for (const fs::path& file : models()) {
    Simulation simulation = loaded(file);
    run(simulation, 300);
    const mjModel& m = simulation.model();
    const mjData& d = simulation.data();
    const auto poses = poses_of(simulation);
    double farthest = 1;
    for (int body = 1; body < m.nbody; ++body) {
      const glm::dmat4 meant = matrix_at(d.xpos + 3 * body, d.xmat + 9 * body);
      for (int i = 0; i < 3; ++i) farthest = std::max(farthest, std::abs(meant[3][i]));
      const std::string name = m.names + m.name_bodyadr[body];
      const auto found = poses.find(name.empty() ? "body_" + std::to_string(body) : name);
      ASSERT_NE(found, poses.end()) << file << " " << body;
      EXPECT_LE(apart(found->second, meant), 1e-7 * farthest) << file << " " << name;
    }
    for (int camera = 0; camera < m.ncam; ++camera) {
      const auto found = poses.find(convert::names_of(m).cameras[static_cast<size_t>(camera)]);
      ASSERT_NE(found, poses.end());
      EXPECT_LE(apart(found->second, matrix_at(d.cam_xpos + 3 * camera, d.cam_xmat + 9 * camera)), 1e-6)
          << file;
    }
    for (int light = 0; light < m.nlight; ++light) {
      const auto found = poses.find(convert::names_of(m).lights[static_cast<size_t>(light)]);
      ASSERT_NE(found, poses.end());
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(-found->second[2][i], d.light_xdir[3 * light + i], 1e-6) << file;
        EXPECT_NEAR(found->second[3][i], d.light_xpos[3 * light + i], 1e-5) << file;
      }
    }
  }
}

TEST(MujocoAdapter, TendonsMatchMuJoCo) {
  Simulation simulation = loaded(in_tree(kCrane));
  const mjModel& m = simulation.model();
  const mjData& d = simulation.data();
  bool lay_on_drum = false;
  for (int i = 0; i < 40; ++i) {
    run(simulation, 25);
    const auto poses = poses_of(simulation);
    for (const char* tendon : {"rope", "tackle"}) {
      const int index = mj_name2id(&m, mjOBJ_TENDON, tendon);
      int piece = 0;
      for (int p = d.ten_wrapadr[index]; p + 1 < d.ten_wrapadr[index] + d.ten_wrapnum[index]; ++p) {
        if (d.wrap_obj[p] == -2 || d.wrap_obj[p + 1] == -2) continue;
        const glm::dmat4& pose = poses.at(std::string(tendon) + "#" + std::to_string(piece));
        const bool lies_on = d.wrap_obj[p] >= 0 && d.wrap_obj[p + 1] >= 0;
        lay_on_drum |= lies_on;
        for (const double side : {-1.0, 1.0}) {  // a cylinder from -1 to 1
          const glm::dvec3 end(pose * glm::dvec4(0, 0, side, 1));
          const mjtNum* meant = d.wrap_xpos + 3 * (side < 0 ? p : p + 1);
          EXPECT_LT(glm::distance(end, glm::dvec3(meant[0], meant[1], meant[2])), 1e-6) << tendon << piece;
        }
        EXPECT_NEAR(glm::length(glm::dvec3(pose[0])), lies_on ? 0.006 : 0.012, 1e-7);
        ++piece;
      }
    }
    const int used = d.ten_wrapnum[0] - 1;
    for (int spare = used; spare < 3; ++spare)
      EXPECT_EQ(glm::determinant(glm::dmat3(poses.at("rope#" + std::to_string(spare)))), 0) << "is seen";
    EXPECT_FALSE(poses.contains("unseen#0"));
  }
  EXPECT_TRUE(lay_on_drum);
}

// Returns the rest transform of each scene node, in the frame of the description file.
std::map<std::string, glm::dmat4> at_rest(const convert::Model& model) {
  std::vector<glm::dmat4> matrices;
  std::map<std::string, glm::dmat4> by_name;
  for (const convert::Node& node : model.nodes) {
    glm::dmat4 matrix(glm::mat3_cast(node.rotation));
    for (int axis = 0; axis < 3; ++axis) matrix[axis] *= node.scale[axis];
    matrix[3] = glm::dvec4(node.translation, 1);
    if (node.parent) matrix = matrices[*node.parent] * matrix;
    matrices.push_back(matrix);
    EXPECT_TRUE(by_name.emplace(node.name, matrix).second) << node.name << " is there twice";
  }
  return by_name;
}

TEST(MujocoAdapter, NamesMatchTheScene) {
  for (const fs::path& file : models()) {
    const auto model = convert::read_mjcf(file, {});
    ASSERT_TRUE(model.ok()) << model.error().message;
    const auto rest = at_rest(*model);
    const Simulation simulation = loaded(file);
    for (const auto& [name, pose] : poses_of(simulation)) {
      const auto found = rest.find(name);
      ASSERT_NE(found, rest.end()) << file << ": " << name << " is no node of the scene";
      EXPECT_LT(apart(found->second, pose), 1e-5) << file << ": " << name;
    }
  }
}

TEST(MujocoAdapter, SeparateGeomsMatchMjData) {
  Simulation simulation = loaded(in_tree(kCrane));
  convert::ReadOptions options;
  options.geoms_apart = true;
  const auto model = convert::read_mjcf(in_tree(kCrane), options);
  ASSERT_TRUE(model.ok());
  const auto rest = at_rest(*model);
  const mjModel& m = simulation.model();
  const mjData& d = simulation.data();
  const convert::MjcfNames names = convert::names_of(m);
  EXPECT_EQ(names.geoms[2], "drum geom") << "a body has that name";
  int shown = 0;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const auto found = rest.find(names.geoms[static_cast<size_t>(geom)]);
    EXPECT_EQ(found != rest.end(), m.geom_group[geom] < 3) << geom;
    if (found == rest.end()) continue;
    ++shown;
    EXPECT_LT(apart(found->second, matrix_at(d.geom_xpos + 3 * geom, d.geom_xmat + 9 * geom)), 1e-9) << geom;
  }
  EXPECT_EQ(shown, 6);
  std::vector<std::string> warnings;
  const auto glb = scene_of(m, d, "crane", warnings);
  ASSERT_TRUE(glb.ok()) << glb.error().message;
  const auto scene = scene::load_glb(*glb, "crane");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(warnings.empty()) << warnings.front();
}

TEST(Simulation, DriveStaysInRange) {
  Simulation arm = loaded(in_tree("tests/assets/robots/arm.xml"));
  const std::vector<mjtNum> first(arm.data().qpos, arm.data().qpos + arm.model().nq);
  EXPECT_EQ(first[0], 0.5) << "the first keyframe is where it begins";
  run(arm, 200);
  EXPECT_NE(first[0], arm.data().qpos[0]);
  ASSERT_TRUE(arm.reset().ok());
  EXPECT_EQ(first, std::vector<mjtNum>(arm.data().qpos, arm.data().qpos + arm.model().nq));
  EXPECT_EQ(arm.data().time, 0);

  Simulation crane = loaded(in_tree(kCrane));
  bool moved = false;
  for (int step = 0; step < 2000; ++step) {
    ASSERT_TRUE(crane.step().ok());
    EXPECT_LE(std::abs(crane.data().ctrl[0]), 4);
    moved |= std::abs(crane.data().ctrl[1]) > 0.05;
  }
  EXPECT_TRUE(moved);
  Simulation still = loaded(in_tree(kCrane), Drive::zero);
  run(still, 10);
  EXPECT_EQ(still.data().ctrl[0], 0);
  for (const char* keyframe : {"1", "-1", "none such"}) {
    const auto wrong = Simulation::load(in_tree("tests/assets/robots/arm.xml"), keyframe, Drive::hold);
    ASSERT_FALSE(wrong.ok());
    EXPECT_NE(wrong.error().message.find(keyframe), std::string::npos);
  }
}

void (*const kErrorAtStart)(const char*) = mju_user_error;

TEST(Simulation, WarningHandlerIsRestored) {
  static int warned = 0;
  mju_user_warning = [](const char*) { ++warned; };
  std::vector<std::string> warnings;
  ASSERT_TRUE(convert::call_mujoco([] { mju_warning("within"); }, &warnings).ok());
  EXPECT_FALSE(convert::call_mujoco([] { mju_error("a fault"); }, &warnings).ok());
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warned, 0);
  mju_warning("later");
  EXPECT_EQ(warned, 1);
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_EQ(mju_user_error, kErrorAtStart);
  mju_user_warning = nullptr;
}

// The linked MuJoCo may be older than the model, which then is shown but not stepped.
TEST(Simulation, RefusedModelNamesLinkedVersion) {
  test::ScratchFolder folder;
  const auto file = folder.write(
      "new.xml",
      std::string_view("<mujoco><worldbody><element_of_the_future/><geom size='1'/></worldbody></mujoco>"));
  const Result<Simulation> simulation = Simulation::load(file, "", Drive::hold);
  ASSERT_FALSE(simulation.ok());
  const std::string& message = simulation.error().message;
  EXPECT_NE(message.find(std::string("MuJoCo ") + mj_versionString()), std::string::npos) << message;
  EXPECT_NE(message.find("fire3dv can show it"), std::string::npos) << message;
  const Result<convert::Model> shown = convert::read_mjcf(file, {});
  ASSERT_TRUE(shown.ok());
  EXPECT_EQ(shown->meshes.size(), 1u);
}

TEST(Simulation, FatalErrorEndsOneCall) {
  const test::ScratchFolder folder;
  std::string bodies;  // falling bodies, whose contacts exceed the arena memory
  for (int i = 1; i <= 12; ++i)
    bodies += "<body pos='0 0 " + std::to_string(0.2 * i) + "'><freejoint/><geom size='0.09'/></body>";
  Result<Simulation> simulation = Error{"none yet"};
  for (double words = 500; !simulation && words < 1e6; words *= 1.1) {  // enough without contacts
    simulation = Simulation::load(
        folder.write("full.xml",
                     std::string_view("<mujoco><size nstack='" + std::to_string(std::lround(words)) +
                                      "'/><worldbody><geom type='plane' size='9 9 1'/>" + bodies +
                                      "</worldbody></mujoco>")),
        "", Drive::hold);
  }
  ASSERT_TRUE(simulation.ok()) << simulation.error().message;
  std::string said;
  for (int step = 0; said.empty() && step < 1000; ++step)
    if (const Result<void> done = simulation->step(); !done) said = done.error().message;
  EXPECT_NE(said.find("cannot step the model: "), std::string::npos) << said;
  EXPECT_NE(said.find("tack overflow"), std::string::npos) << said;
  Simulation other = loaded(in_tree(kCrane));
  run(other, 10);
}

}  // namespace
}  // namespace fire3dv::mujoco

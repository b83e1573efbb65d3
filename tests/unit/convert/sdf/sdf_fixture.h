// Fixture of tests of the SDF reader.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "convert/readers.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::convert {

class Sdf : public testing::Test {
 protected:
  static std::string world(const std::string& inside, const std::string& version = "1.9") {
    return "<?xml version=\"1.0\"?>\n<sdf version=\"" + version + "\">\n<world name=\"w\">\n" + inside +
           "</world>\n</sdf>\n";
  }
  std::filesystem::path write(const std::string& name, std::string_view text) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    return folder_.write(name, text);
  }
  Result<Model> try_read(const std::string& text, const ReadOptions& options = {}) {
    return read_description(write("world.sdf", text), options);
  }
  Model read(const std::string& inside, const ReadOptions& options = {}) {
    auto model = try_read(world(inside), options);
    EXPECT_TRUE(model.ok()) << model.error().message;
    return model ? std::move(*model) : Model();
  }
  std::string error_of(const std::string& text) {
    const auto model = try_read(text);
    EXPECT_FALSE(model.ok()) << text;
    return model ? "" : model.error().message;
  }

  static const Node* node(const Model& model, const std::string& name) {
    const auto found = std::ranges::find(model.nodes, name, &Node::name);
    return found == model.nodes.end() ? nullptr : &*found;
  }
  static std::string warnings(const Model& model) {
    std::string all;
    for (const std::string& warning : model.warnings) all += warning + "\n";
    return all;
  }
  static bool warns(const Model& model, const std::string& text) {
    return warnings(model).find(text) != std::string::npos;
  }
  // Pose in the frame of the file.
  static glm::dmat4 pose_of(const Model& model, const std::string& name) {
    glm::dmat4 pose(1);
    for (const Node* at = node(model, name); at; at = at->parent ? &model.nodes[*at->parent] : nullptr) {
      glm::dmat4 local = glm::mat4_cast(at->rotation);
      local[3] = glm::dvec4(at->translation, 1);
      pose = local * pose;
    }
    return pose;
  }
  static void expect_near(const glm::dvec3& a, const glm::dvec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-6) << a.x << ' ' << a.y << ' ' << a.z;
  }
  static const Surface& surface(const Model& model, const std::string& name) {
    static const Surface none;
    const Node* found = node(model, name);
    EXPECT_TRUE(found && found->mesh) << name << " has no mesh";
    return found && found->mesh ? model.meshes[*found->mesh].surfaces.front() : none;
  }
  static std::pair<glm::vec3, glm::vec3> bounds(const Surface& surface) {
    glm::vec3 low(1e9f), high(-1e9f);
    for (const glm::vec3& position : surface.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
    return {low, high};
  }

  static std::string visual(const std::string& geometry, const std::string& more = "",
                            const std::string& name = "v") {
    return "<visual name=\"" + name + "\"><geometry>" + geometry + "</geometry>" + more + "</visual>\n";
  }
  static std::string link(const std::string& name, const std::string& inside = "") {
    return "<link name=\"" + name + "\">" + inside + "</link>\n";
  }
  static std::string model_of(const std::string& name, const std::string& inside) {
    return "<model name=\"" + name + "\">" + inside + "</model>\n";
  }
  // A model with one visual: m/l/v.
  static std::string shape(const std::string& geometry, const std::string& more = "") {
    return model_of("m", link("l", visual(geometry, more)));
  }

  test::ScratchFolder folder_;
};

}  // namespace fire3dv::convert

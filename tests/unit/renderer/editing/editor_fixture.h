// Fixture of tests of a window's scene editor: three boxes, a view state and a folder.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/plural.h"
#include "protocol/robot/robot_file.h"
#include "renderer/editing/edit_session.h"
#include "renderer/editing/overlay_file.h"
#include "renderer/editing/view_transfer.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {

namespace fs = std::filesystem;

class Editors : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(::testing::TempDir()) /
        ("fire3dv_editor_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  state::EditTargets targets() const { return {scene_, names_}; }
  void update(EditSession& editor, bool is_interacting = false) { editor.update(targets(), is_interacting); }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  OverlayFile file(bool was_named = true) const {
    const fs::path path = folder_ / "boxes.overlay.json";
    return {path, "boxes.glb", was_named, false, {}, was_named ? digest_of_overlay(path) : std::nullopt};
  }

  fs::path folder_;
  scene::Scene scene_ = boxes_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  state::NodeNames names_{scene_};
  ViewState view_state_;
};

}  // namespace fire3dv::app

// Loads a built glTF document through a file and the loader.
#pragma once

#include <gtest/gtest.h>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {

inline Result<Scene> load(const test::GltfBuilder& builder) {
  const test::ScratchFolder folder;
  return load_gltf(folder.write("scene.glb", builder.glb()));
}

// Expects success. On failure the test fails and the scene is empty.
inline Scene loaded(const test::GltfBuilder& builder) {
  auto scene = load(builder);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return scene ? std::move(*scene) : Scene{};
}

}  // namespace fire3dv::scene

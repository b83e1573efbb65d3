// Fixture of MJCF tests: reads a model's text from a file in its own folder.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "convert/mjcf/mjcf_reader.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::convert {

class Mjcf : public testing::Test {
 protected:
  Result<Model> try_read(const std::string& text, const ReadOptions& options = {}) {
    return read_mjcf(folder_.write("model.xml", std::string_view(text)), options);
  }
  // The scene of a model whose elements these are; fails the test if it cannot be read.
  MjcfScene scene(const std::string& elements) {
    Sources sources;
    warnings_.clear();
    Result<MjcfScene> read =
        read_mjcf_scene(folder_.write("model.xml", std::string_view("<mujoco>" + elements + "</mujoco>")), {},
                        sources, warnings_);
    EXPECT_TRUE(read.ok()) << (read ? "" : read.error().message);
    return read ? std::move(*read) : MjcfScene();
  }
  std::vector<std::string> warnings_;  // of the last scene()
  test::ScratchFolder folder_;
};

}  // namespace fire3dv::convert

// Fixture of MJCF tests: reads a model's text from a file in its own folder.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/support/gltf_builder.h"
#include "tools/convert/readers.h"

namespace fire3dv::convert {

class Mjcf : public testing::Test {
 protected:
  Result<Model> try_read(const std::string& text, const ReadOptions& options = {}) {
    return read_mjcf(folder_.write("model.xml", std::string_view(text)), options);
  }
  test::ScratchFolder folder_;
};

}  // namespace fire3dv::convert

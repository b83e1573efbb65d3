// Fixture of tests of models that libmujoco compiles: checks their files first, as fire3dv-mujoco does.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "adapters/mujoco/compiled/load.h"
#include "adapters/mujoco/compiled/model_files.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::convert {

inline Result<Model> read_compiled(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  if (const Result<Sources> files = mjcf_files(file, options.package_folders); !files) return files.error();
  const Result<MjcfModel> compiled = compile_mjcf(file, &model.warnings);
  if (!compiled) return compiled.error();
  const Result<MjcfData> posed = pose_mjcf(**compiled, &model.warnings);
  if (!posed) return posed.error();
  add_mjcf(**compiled, **posed, options, model);
  return model;
}

class CompiledMjcf : public testing::Test {
 protected:
  Result<Model> try_read(const std::string& text, const ReadOptions& options = {}) {
    return read_compiled(folder_.write("model.xml", std::string_view(text)), options);
  }
  test::ScratchFolder folder_;
};

}  // namespace fire3dv::convert

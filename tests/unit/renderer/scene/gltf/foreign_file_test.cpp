// Test of files that are no glTF: the message names the file, its format and the remedy.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "renderer/scene/gltf/foreign_file.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

struct ForeignFile {
  const char* name;
  std::string bytes;
  const char* format;
  const char* remedy;
};

TEST(ForeignFile, IsNamedWithItsRemedy) {
  const test::ScratchFolder folder;
  const std::string binary_stl(84 + 50, '\0');
  for (const auto& [name, bytes, format, remedy] : std::vector<ForeignFile>{
           {"cube.obj", "# made by hand\nv 0 0 0\n", "OBJ", "fire3dv-convert"},
           {"cube.STL", "solid cube\nfacet normal 0 0 1\n", "STL", "fire3dv-convert"},
           {"part.stl", binary_stl, "STL", "fire3dv-convert"},
           {"part.glb", "solid cube\nfacet normal 0 0 1\n", "STL", ".stl"},
           {"scan.glb", "ply\nformat ascii 1.0\n", "PLY", ".ply"},
           {"a.step", "ISO-10303-21;\nHEADER;\n", "STEP", "FreeCAD"},
           {"a.glb", std::string(72, ' ') + "S      1\n", "IGES", "FreeCAD"},
           {"a.glb", "BLENDER-v300", "Blender project", "File > Export > glTF"},
           {"a.blend", "\x28\xB5\x2F\xFD", "Blender project", "File > Export > glTF"},
           {"a.glb", "\x1F\x8B\x08", "gzip", "unpack"},
           {"a.glb", "PK\x03\x04" + std::string(26, '\0') + "scene.glb", "ZIP", "unpack"},
           {"a.glb", "PK\x03\x04" + std::string(26, '\0') + "3D/3dmodel.model", "3MF", ".3mf"},
           {"a.glb", std::string("RIFF\0\0\0\0WEBPVP8 ", 16), "WebP image", "name a scene"},
           {"a.glb", "<!DOCTYPE html>\n<html>", "web page", "raw"},
           {"a.glb", "<?xml version=\"1.0\"?>\n<sdf version=\"1.7\">", "SDF", "fire3dv-convert FILE"},
           {"a.mtl", "newmtl red\n", "materials of an OBJ", ".obj"},
           {"a.glb", "hello\n", "a text file", "as glTF"},
           {"scene.usda", "#usda 1.0\n(\n)\n", "USD", "as glTF"},
           {"scene.usdc", "PXR-USDC\1", "USD", "as glTF"},
           {"arm.dae", "<?xml version=\"1.0\"?>\n<COLLADA version=\"1.4.1\">", "COLLADA", ".dae"},
           {"arm.glb", "<?xml version=\"1.0\"?>\n<robot name=\"arm\"/>", "URDF", "fire3dv-convert"},
           {"arm.txt", "\xEF\xBB\xBF\n <mujoco model=\"a\"/>", "MJCF", "fire3dv-convert"},
           {"empty.glb", "", "empty", ".glb"},
           {"run.glb", "\x89MCAP0\r\n", "MCAP", "--replay"},
           {"bag.db3", "SQLite format 3", "bag of ROS 2", "fire3dv relabel FILE"},
           {"demo.hdf5", "\x89HDF\r\n\x1a\n", "HDF5", "fire3dv relabel FILE"},
           {"lfs.glb", "version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "Git LFS",
            "git lfs pull"},
           {"noise.glb", "\x01\x02\x03", "neither JSON nor binary", "as glTF"}}) {
    const auto scene = load_gltf(folder.write(name, std::as_bytes(std::span(bytes))), {});
    ASSERT_FALSE(scene.ok()) << name;
    const std::string& message = scene.error().message;
    EXPECT_NE(message.find(name), std::string::npos) << message;
    EXPECT_NE(message.find(format), std::string::npos) << message;
    EXPECT_NE(message.find(remedy), std::string::npos) << message;
    const auto checked = check_is_gltf(folder.path() / name);
    ASSERT_FALSE(checked.ok()) << name;
    EXPECT_EQ(checked.error().message, message);
  }
}

TEST(ForeignFile, GltfIsNone) {
  const test::ScratchFolder folder;
  for (const std::string text : {"glTF\2", "{\"asset\": 1", "\xEF\xBB\xBF \n{}", "[1]"}) {
    EXPECT_FALSE(describe_foreign_file(std::as_bytes(std::span(text)), "scene.stl")) << text;
    (void)folder.write("scene.glb", std::as_bytes(std::span(text)));
    EXPECT_TRUE(check_is_gltf(folder.path() / "scene.glb").ok()) << text;
  }
  const auto is_folder = check_is_gltf(folder.path());
  ASSERT_FALSE(is_folder.ok());
  EXPECT_NE(is_folder.error().message.find("a folder; name a scene in it, such as \"scene.glb\""),
            std::string::npos)
      << is_folder.error().message;
  const std::string glb = "glTF\2";
  EXPECT_TRUE(is_binary_gltf(folder.write("scene.stl", std::as_bytes(std::span(glb)))));
  EXPECT_FALSE(is_binary_gltf(folder.path() / "nope.glb"));
  EXPECT_FALSE(is_binary_gltf(folder.path()));
  const auto missing = check_is_gltf(folder.path() / "nope.glb");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().message.find("No such file"), std::string::npos) << missing.error().message;
}

}  // namespace
}  // namespace fire3dv::scene

// Security test of models that libmujoco compiles: which files they may name.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "tests/unit/adapters/mujoco/compiled_mjcf.h"

namespace fire3dv::convert {
namespace {

// Security: an untrusted model names files outside of its folder, in several disguises; none of them is read.
TEST_F(CompiledMjcf, OutsideFilesNeedOption) {
  namespace fs = std::filesystem;
  const fs::path model = folder_.path() / "model", ours = folder_.path() / "ours";
  fs::create_directories(model / "assets");
  fs::create_directories(ours);
  constexpr std::string_view kTetrahedron =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const auto write = [&](const char* name, const std::string& text) {
    return folder_.write(name, std::string_view(text));
  };
  write("ours/t.obj", std::string(kTetrahedron));
  write("ours/key.mtl", "newmtl secret\n");
  folder_.write("ours/skin.png", test::png(2, 2, 0x00ff00ff));
  write("ours/parts.xml", "<mujoco><option/></mujoco>");
  fs::create_symlink(ours, model / "link");
  fs::create_symlink(ours / "t.obj", model / "link.obj");
  const std::string library = "mtllib own.mtl ";
  const auto mesh = [](const std::string& file) {
    return "<asset><mesh name='m' file='" + file + "'/></asset>";
  };
  const auto texture = [](const std::string& attribute, const std::string& file, const char* type) {
    return "<asset><texture name='t' type='" + std::string(type) + "' " + attribute + "='" + file +
           "'/></asset>";
  };
  const auto folder = [](const char* which, const std::string& where) {
    return "<compiler " + std::string(which) + "='" + where + "'/>";
  };
  write("model/above.obj", library + "../ours/key.mtl\n" + std::string(kTetrahedron));
  write("model/late.OBJ", std::string(kTetrahedron) + "\r \tmtllib\tlink/key.mtl\r\n");
  // The OBJ reader treats a backslash as a slash; libmujoco needs no dot before "obj".
  write("model/link\\t.obj", "mtllib key.mtl\n" + std::string(kTetrahedron));
  write("model/.obj", "mtllib link/key.mtl\n" + std::string(kTetrahedron));
  write("model/teapotobj", "mtllib link/key.mtl\n" + std::string(kTetrahedron));
  write("model/sub.xml", "<mujoco>" + mesh("../ours/t.obj") + "</mujoco>");
  const struct {
    std::string text, named;
  } cases[] = {
      {mesh("../ours/t.obj"), "ours/t.obj"},
      {mesh((ours / "t.obj").string()), "ours/t.obj"},
      {mesh("link/t.obj"), "link/t.obj"},
      {mesh("link.obj"), "link.obj"},
      {mesh("assets/../../ours/t.obj"), "ours/t.obj"},
      {folder("meshdir", "../ours") + mesh("t.obj"), "ours/t.obj"},
      {folder("meshdir", ours.string()) + mesh("t.obj"), "ours/t.obj"},
      {folder("meshdir", "link") + mesh("t.obj"), "link/t.obj"},
      {"<compiler strippath='true' meshdir='link'/>" + mesh("C:\\robot\\t.obj"), "link/t.obj"},
      {texture("file", "../ours/skin.png", "2d"), "ours/skin.png"},
      {folder("texturedir", "assets/../link") + texture("file", "skin.png", "2d"), "link/skin.png"},
      {texture("fileup", (ours / "skin.png").string(), "cube"), "ours/skin.png"},
      {"<asset><hfield name='h' file='../ours/skin.png' size='1 1 1 1'/></asset>", "ours/skin.png"},
      {"<include file='../ours/parts.xml'/>", "ours/parts.xml"},
      {"<include file='link/parts.xml'/>", "link/parts.xml"},
      {"<include file='sub.xml'/>", "ours/t.obj"},
      {"<Include file='sub.xml'/>", "ours/t.obj"},
      {mesh("above.obj"), "ours/key.mtl"},
      {mesh("late.OBJ"), "link/key.mtl"},
      {mesh("link\\t.obj"), "link/key.mtl"},
      {mesh(".obj"), "link/key.mtl"},
      {mesh("teapotobj"), "link/key.mtl"},
  };
  ReadOptions named;
  named.package_folders = {ours};
  for (const auto& [text, name] : cases) {
    const fs::path file = write("model/model.xml", "<mujoco>" + text + "<worldbody/></mujoco>");
    const Result<Model> read = read_compiled(file, {});
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_NE(read.error().message.find(name + "\", which lies outside the model's folder"),
              std::string::npos)
        << text << ": " << read.error().message;
    EXPECT_NE(read.error().message.find("--package-path"), std::string::npos) << read.error().message;
    const Result<Model> allowed = read_compiled(file, named);
    EXPECT_TRUE(allowed.ok()) << text << ": " << (allowed ? "" : allowed.error().message);
  }
  // Files below the folder are read by any path; also if the model itself is reached through a link.
  const fs::path below = write("model/model.xml", "<mujoco>" + folder("meshdir", "assets") +
                                                      mesh("../late.OBJ") + "<worldbody/></mujoco>");
  EXPECT_FALSE(read_compiled(below, {}).ok()) << "its materials lie outside";
  write("model/late.OBJ", library + "\n" + std::string(kTetrahedron));
  EXPECT_TRUE(read_compiled(below, {}).ok());
  // Symlink trees of package managers: the resolved folder of the model counts in addition to the link's.
  fs::create_directories(folder_.path() / "tree/assets");
  fs::create_symlink(below, folder_.path() / "tree/model.xml");
  fs::create_symlink(model / "late.OBJ", folder_.path() / "tree/late.OBJ");
  EXPECT_TRUE(read_compiled(folder_.path() / "tree/model.xml", {}).ok());
}

// libmujoco concatenates folder and file names as text, and has its own rule for absolute paths.
TEST_F(CompiledMjcf, WorkingFolderIsOutside) {
  namespace fs = std::filesystem;
  constexpr std::string_view kTetrahedron =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (const char* name : {"model/a:start", "start/d:", "start/start"})
    fs::create_directories(folder_.path() / name);
  const auto write = [&](const char* name, const std::string& text) {
    return folder_.write(name, std::string_view(text));
  };
  const fs::path key = write("start/key.mtl", "newmtl secret\n");
  const fs::path parts = write("start/parts.xml", "<mujoco><option/></mujoco>");
  write("start/start/key.mtl", "newmtl secret\n");
  write("start/d:/t.obj", std::string(kTetrahedron));
  write("model/a:start/t.obj", "mtllib key.mtl\n" + std::string(kTetrahedron));
  write("model/t.obj", "mtllib " + key.string() + "\n" + std::string(kTetrahedron));
  const fs::path before = fs::current_path();
  const auto refusal = [&](const char* from, const char* model, const std::string& text) {
    write("model/model.xml", "<mujoco>" + text + "<worldbody/></mujoco>");
    fs::current_path(folder_.path() / from);
    const Result<Model> read = read_compiled(model, {});
    fs::current_path(before);
    return read.ok() ? std::string("none") : read.error().message;
  };
  const auto mesh = [](const std::string& file) {
    return "<asset><mesh name='m' file='" + file + "'/></asset>";
  };
  const struct {
    const char *from, *model;
    std::string text, named;
  } cases[] = {
      {"start", "../model/model.xml", mesh("d:/t.obj"), "d:/t.obj"},
      {"start", "../model/model.xml", "<compiler meshdir='d:'/>" + mesh("t.obj"), "d:/t.obj"},
      {"start", "../model/model.xml", mesh("a:start/t.obj"), "start/key.mtl"},
      {"model", "model.xml", mesh("t.obj"), "start/key.mtl"},
      {"model", "model.xml", "<include file='" + parts.string() + "'/>", "start/parts.xml"},
  };
  for (const auto& [from, model, text, named] : cases) {
    const std::string message = refusal(from, model, text);
    EXPECT_NE(message.find(named + "\", which lies outside"), std::string::npos) << text << ": " << message;
  }
  EXPECT_NE(refusal("model", "model.xml", mesh("t&#10;.obj")).find("control characters"), std::string::npos);
  const fs::path split = write("model/a\\b.xml", "<mujoco><worldbody/></mujoco>");
  const Result<Model> read = read_compiled(split, {});
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("holds a backslash"), std::string::npos) << read.error().message;
}

}  // namespace
}  // namespace fire3dv::convert

// Test of the ADF reader on invalid, hostile and unusual files. Unsupported content is reported with file and
// line; no input hangs, crashes or opens a path that is no file.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

std::string all_of(const Model& model) {
  std::string text;
  for (const std::string& warning : model.warnings) {
    EXPECT_EQ(warning.find('\n'), std::string::npos) << warning;
    text += warning + '\n';
  }
  return text;
}

// Returns the error, or the warnings.
std::string said_of(std::string_view yaml, const ReadOptions& options = {}) {
  const test::ScratchFolder folder;
  const Result<Model> model = read_adf(folder.write("model.yaml", yaml), options);
  if (model) return all_of(*model);
  EXPECT_EQ(model.error().message.find('\n'), std::string::npos) << model.error().message;
  EXPECT_NE(model.error().message.find("model.yaml"), std::string::npos) << model.error().message;
  return "refused: " + model.error().message;
}

void expect_said(std::string_view yaml, const std::string& what) {
  const std::string said = said_of(yaml);
  EXPECT_NE(said.find(what), std::string::npos) << "of\n" << yaml.substr(0, 300) << "\nit says\n" << said;
}

TEST(AdfRefuse, OtherFilesAreRefused) {
  expect_said("bodies: [a\n\nb: {c: d", "model.yaml:");
  expect_said("bodies: [a]\na:\n  name: [x\nb: 1\n", "refused: ");
  expect_said("just a text", "is no AMBF description");
  expect_said("", "is no AMBF description");
  expect_said("- a\n- b\n", "is no AMBF description");
  expect_said("name: robot\n", "is no AMBF launch, world or model file");
  expect_said("bodies: []\n", "shows nothing");
  expect_said(std::string("bodies: \0\xff\xfe", 11), "refused: ");
  const test::ScratchFolder folder;
  const auto refusal = [](const std::filesystem::path& file) {
    const Result<Model> model = read_adf(file, {});
    return model ? std::string("read") : model.error().message;
  };
  EXPECT_NE(refusal(folder.path() / "gone.yaml").find("No such file"), std::string::npos);
  EXPECT_NE(refusal(folder.path()).find("is a folder"), std::string::npos);
  ASSERT_EQ(mkfifo((folder.path() / "pipe.yaml").c_str(), 0600), 0);
  EXPECT_NE(refusal(folder.path() / "pipe.yaml").find("not a regular file"), std::string::npos);
  EXPECT_NE(refusal("/dev/zero").find("not a file on a disk"), std::string::npos);
}

TEST(AdfRefuse, InvalidValuesAreNamedByLine) {
  expect_said("bodies: [b]\nb:\n  shape: BOX\n  geometry: {x: wide, y: 1, z: 1}\n",
              "model.yaml:4: \"x\" is not a number");
  expect_said("bodies: [b]\nb:\n  shape: BOX\n  geometry: {x: .nan, y: 1, z: 1}\n",
              "model.yaml:4: \"x\" is not a number");
  expect_said("bodies: [b]\nb: {shape: BALL}\n", "model.yaml:2: \"shape\" is none of BOX");
  expect_said("bodies: [b]\nb: {shape: SPHERE, geometry: {radius: 1e300}}\n",
              "has no size that can be drawn");
  expect_said("bodies: [b]\nb: {shape: SPHERE, geometry: {radius: -1}}\n", "has no size that can be drawn");
  expect_said("bodies: [b]\nb:\n  location:\n    position: [1, 2, 3]\n",
              "model.yaml:4: \"position\" has no x, y and z");
  expect_said("bodies: [b]\nb:\n  location:\n    position: {x: 1, y: 2}\n", "\"position\" has no z");
  expect_said("bodies: [b]\nb:\n  use material: perhaps\n  color rgba: {r: 1, g: 1, b: 1, a: 1}\n",
              "\"use material\" is neither true nor false");
  expect_said("bodies: [b]\nb: {color components: {diffuse: {r: 1, g: 1, b: 1}}}\n",
              "has no \"transparency\"");
  expect_said("bodies: [b, [c]]\nb: {}\n", "is not text");
  expect_said("bodies: b\nb: {}\nghost objects: [g]\ng: {}\n", "\"bodies\" is not a list");
  expect_said("bodies: [b]\nb: {}\nb: {}\n", "model.yaml:3: \"b\" is defined twice; the first one applies");
  expect_said("bodies: [b]\nb: {mesh: /dev/zero}\n", "not a file on a disk");
  expect_said("bodies: [b]\nb: {mesh: /etc/passwd}\n", ".obj, .stl, .ply, .3ds, .dae, .glb and .gltf");
  expect_said("bodies: [b]\nb: {}\ncameras: [c]\nc: {look at: {x: 0, y: 0, z: 1}}\n",
              "its direction is undefined");
  expect_said("bodies: [b]\nb: {}\ncameras: [c]\nc: {clipping plane: {near: 0, far: -1}}\n",
              "0 < near < far");
  expect_said("bodies: [b]\nb: {}\ncameras: [c]\nc: {field view angle: 9}\n",
              "not an angle that a camera can have");
  expect_said("bodies: [b]\nb: {}\nvehicles: [v]\n", "\"vehicles\" is not converted");
}

TEST(AdfRefuse, OpacityIsClamped) {
  const test::ScratchFolder folder;
  for (const auto& [alpha, expected] : {std::pair{"0.25", 0.25f}, {"-3", 0.0f}, {"1.5", 1.0f}}) {
    const Result<Model> model = read_adf(
        folder.write("model.yaml", std::string("bodies: [b]\nb:\n  shape: SPHERE\n  geometry: {radius: 1}\n"
                                               "  color rgba: {r: 1, g: 1, b: 1, a: ") +
                                       alpha + "}\n"),
        {});
    ASSERT_TRUE(model);
    const Material& material = model->materials[model->meshes[0].surfaces[0].material];
    EXPECT_FLOAT_EQ(material.base_color.a, expected);
    EXPECT_EQ(material.blended, expected < 1);
  }
}

TEST(AdfRefuse, NamesAreFitForStreams) {
  const test::ScratchFolder folder;
  const Result<Model> model =
      read_adf(folder.write("model.yaml",
                            "bodies: [\"a\\nb\\x01\", \"\\u202Eback\", twice]\nghost objects: [twice]\n"
                            "\"a\\nb\\x01\": {}\n\"\\u202Eback\": {}\ntwice: {}\n"),
               {});
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_EQ(model->nodes.size(), 4u);
  EXPECT_EQ(model->nodes[0].name, "a?b?");
  EXPECT_EQ(model->nodes[1].name, "?back");
  EXPECT_EQ(model->nodes[2].name, "twice");
  EXPECT_EQ(model->nodes[3].name, "twice#ghost");  // AMBF has a name map per kind; a scene has one
}

// AMBF drops a body without its mesh, and gives its name to the next one.
TEST(AdfRefuse, DroppedNamesAreFree) {
  const test::ScratchFolder folder;
  folder.write("part.stl", test::binary_stl());
  const Result<Model> model =
      read_adf(folder.write("a.yaml", "bodies: [b]\nenvironment: x\nb: {mesh: gone.stl}\n"), {});
  ASSERT_TRUE(model);
  const Result<Model> launched =
      read_adf((folder.write("other.yaml", "bodies: [b]\nb: {mesh: part.stl}\n"),
                folder.write("launch.yaml", "multibody configs: [a.yaml, other.yaml]\n")),
               [] {
                 ReadOptions options;
                 options.launch_all = true;
                 return options;
               }());
  ASSERT_TRUE(launched);
  ASSERT_EQ(launched->nodes.size(), 2u);
  EXPECT_EQ(launched->nodes[0].name, "b1");
  EXPECT_EQ(launched->nodes[1].name, "b");
  EXPECT_TRUE(launched->nodes[1].mesh);
}

TEST(AdfRefuse, LoopsEnd) {
  const test::ScratchFolder folder;
  folder.write("world.yaml", "environment: ./world.yaml\nlights: [l]\nl: {direction: {x: 0, y: 0, z: -1}}\n");
  folder.write("launch.yaml", "world config: world.yaml\nmultibody configs: [../" +
                                  folder.path().filename().string() + "/launch.yaml, launch.yaml]\n");
  const Result<Model> model = read_adf(folder.path() / "launch.yaml", {});
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_NE(
      all_of(*model).find("world.yaml:1: \"environment\" is \"./world.yaml\", which is just being read"),
      std::string::npos)
      << all_of(*model);
  EXPECT_NE(all_of(*model).find("launch.yaml\", which is just being read"), std::string::npos);
  expect_said("bodies: [b]\nb: {}\ncameras: [c, d]\nc: {parent: d}\nd: {parent: c}\n",
              "among its own parents");
}

TEST(AdfRefuse, ParentLookupMatchesAmbf) {
  const test::ScratchFolder folder;
  const Result<Model> model =
      read_adf(folder.write("model.yaml",
                            "namespace: /n/\nbodies: [BODY a, BODY ab, BODY c]\nghost objects: [G1, G2, G3]\n"
                            "BODY a: {}\nBODY ab: {}\nBODY c: {}\n"
                            "G1: {parent: /n/BODY a}\nG2: {parent: BODY c}\nG3: {parent: BODY a}\n"),
               {});
  ASSERT_TRUE(model);
  EXPECT_EQ(model->nodes[3].parent, 0u);            // its complete name
  EXPECT_EQ(model->nodes[4].parent, 2u);            // a part of one name
  EXPECT_EQ(model->nodes[5].parent, std::nullopt);  // a part of two names: ambiguous
}

TEST(AdfRefuse, BombsAreBounded) {
  expect_said("bodies: " + std::string(100000, '['), "refused: ");
  std::string deep;
  for (int i = 0; i < 1500; ++i) deep += std::string(static_cast<size_t>(i), ' ') + "a:\n";
  expect_said("bodies: [b]\nb: {}\n" + deep, "refused: ");
  // Billion-laughs attack: each alias doubles the one before.
  std::string bomb = "bodies: [b]\na0: &a0 [x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last + ", " + last + "]\n";
  }
  said_of(bomb + "b: {compound shape: *a29}\n");
  said_of("bodies: [b]\nb: &b {compound shape: *b, self: *b}\n");
  // One entry listed many times.
  std::string many = "bodies: [";
  for (int i = 0; i < 20100; ++i) many += "b,";
  expect_said(many + "]\nb: {}\n", "there are more than 20000");
  std::string wide = "bodies: [";
  for (int i = 0; i < 3000; ++i) wide += "b,";
  wide += "]\nb: {";
  for (int i = 0; i < 20000; ++i) wide += "k" + std::to_string(i) + ": 1,";
  expect_said(wide + "}\n", "has more than 200 fields");
  std::string parts = "bodies: [";
  for (int i = 0; i < 400; ++i) parts += "b,";
  parts += "]\ns: &s {shape: BOX, geometry: {x: 1, y: 1, z: 1}}\nb: {compound shape: [";
  for (int i = 0; i < 300; ++i) parts += "*s,";
  expect_said(parts + "]}\n", "there are more than 100000");
}

TEST(AdfRefuse, LaunchReadsOnlyShownModels) {
  const test::ScratchFolder folder;
  std::string many = "bodies: [";
  for (int i = 0; i < 20'001; ++i) many += "b,";
  folder.write("many.yaml", std::string_view(many + "]\nb: {}\n"));
  folder.write("long.yaml", std::string_view("name: " + std::string(1000, 'x') + "\n"));
  ReadOptions all;
  all.launch_all = true;
  const Result<Model> full =
      read_adf(folder.write("launch.yaml", "multibody configs: [many.yaml, gone.yaml]\n"), all);
  ASSERT_TRUE(full) << full.error().message;
  EXPECT_NE(all_of(*full).find("there are more than 20000"), std::string::npos) << all_of(*full);
  EXPECT_EQ(all_of(*full).find("gone.yaml"), std::string::npos) << all_of(*full);
  // The same file without visible content, listed repeatedly.
  all.max_adf_bytes = 2500;
  folder.write("one.yaml", "bodies: [b]\nb: {}\n");
  const Result<Model> again = read_adf(
      folder.write("launch.yaml",
                   "multibody configs: [one.yaml, long.yaml, long.yaml,\n  long.yaml,\n one.yaml]\n"),
      all);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->nodes.size(), 1u);
  EXPECT_NE(all_of(*again).find("launch.yaml:3: \"multibody configs\" cannot be read: the files before it "
                                "have more than 2 KiB together"),
            std::string::npos)
      << all_of(*again);
}

TEST(AdfRefuse, EqualShapesShareMesh) {
  const test::ScratchFolder folder;
  std::string text = "bodies: [a, b";
  for (int i = 0; i < 9; ++i) text += ", c" + std::to_string(i);
  text += "]\na: {shape: BOX, geometry: {x: 1, y: 1, z: 1}}\nb: {shape: BOX, geometry: {x: 1, y: 1, z: 1}}\n";
  for (int i = 0; i < 9; ++i)
    text += "c" + std::to_string(i) + ": {shape: BOX, geometry: {x: 2, y: 1, z: " + std::to_string(i + 1) +
            "}}\n";
  ReadOptions options;
  options.max_triangles = 100;
  const Result<Model> model = read_adf(folder.write("model.yaml", std::string_view(text)), options);
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->nodes[0].mesh, model->nodes[1].mesh);
  EXPECT_EQ(model->meshes.size(), 9u) << "12 triangles each";
  EXPECT_NE(all_of(*model).find("the scene has more than 100 triangles"), std::string::npos)
      << all_of(*model);
}

}  // namespace
}  // namespace fire3dv::convert

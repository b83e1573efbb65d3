// Test of the SDF reader: entities, poses, shapes, materials, lights and cameras. Expected values are
// computed by hand from the format's documentation.
#include <cmath>
#include <numbers>

#include "convert/glb/write_glb.h"
#include "tests/unit/convert/sdf/sdf_fixture.h"

namespace fire3dv::convert {
namespace {

constexpr const char* kBox = "<box><size>1 2 3</size></box>";
constexpr double kQuarter = std::numbers::pi / 2;

TEST_F(Sdf, EntitiesAreNodesWithScopedNames) {
  const Model model = read(model_of(
      "robot", link("base", visual(kBox, "", "shell")) + model_of("arm", link("wrist", visual(kBox)))));
  EXPECT_EQ(model.name, "w");
  ASSERT_TRUE(node(model, "robot/arm/wrist/v"));
  const Node* shell = node(model, "robot/base/shell");
  ASSERT_TRUE(shell && shell->parent && shell->mesh);
  EXPECT_EQ(model.nodes[*shell->parent].name, "robot/base");
  EXPECT_TRUE(node(model, "light from above"));
  EXPECT_EQ(warnings(model), "");
}

TEST_F(Sdf, PosesAreRelativeToFrames) {
  // Fixed axes: roll, pitch, yaw. The second link stands 2 m along the X of the first, which points along Y.
  const Model model =
      read(model_of("m", "<pose>1 0 0 0 0 1.5707963267948966</pose>" +
                             link("a", "<pose>0 0 1 0 0 0</pose>" +
                                           visual(kBox, "<pose degrees='true'>0 0 0 90 0 0</pose>")) +
                             link("b", "<pose relative_to='a'>2 0 0 0 0 0</pose>") +
                             "<frame name='f' attached_to='b'><pose>0 1 0 0 0 0</pose></frame>" +
                             link("c", "<pose relative_to='f'/>")));
  expect_near(glm::dvec3(pose_of(model, "m/a")[3]), {1, 0, 1});
  expect_near(glm::dvec3(pose_of(model, "m/b")[3]), {1, 2, 1});
  expect_near(glm::dvec3(pose_of(model, "m/c")[3]), {0, 2, 1});
  expect_near(glm::dvec3(pose_of(model, "m/a/v")[1]), {0, 0, 1});  // Y of the visual
}

TEST_F(Sdf, ShapesHaveTheirSizes) {
  const auto size = [&](const std::string& geometry) {
    const Model model = read(shape(geometry));
    const auto [low, high] = bounds(surface(model, "m/l/v"));
    EXPECT_LT(glm::length(low + high), 1e-5f) << geometry;  // centred
    return glm::dvec3(high - low);
  };
  expect_near(size(kBox), {1, 2, 3});
  expect_near(size("<sphere><radius>2</radius></sphere>"), {4, 4, 4});
  expect_near(size("<cylinder><radius>0.5</radius><length>3</length></cylinder>"), {1, 1, 3});
  expect_near(size("<capsule><radius>0.5</radius><length>3</length></capsule>"), {1, 1, 4});
  expect_near(size("<ellipsoid><radii>1 2 3</radii></ellipsoid>"), {2, 4, 6});
  expect_near(size("<plane><normal>0 0 1</normal><size>4 2</size></plane>"), {4, 2, 0});
  expect_near(size("<plane><normal>0 1 0</normal><size>4 2</size></plane>"), {4, 0, 2});
  expect_near(size("<cone><radius>0.5</radius><length>3</length></cone>"), {1, 1, 3});  // of SDF 1.11
}

TEST_F(Sdf, PlanesAreSingleSided) {
  const Model model = read(shape("<plane><normal>1 0 0</normal><size>2 2</size></plane>"));
  const Surface& plane = surface(model, "m/l/v");
  for (const glm::vec3& normal : plane.normals) expect_near(glm::dvec3(normal), {1, 0, 0});
  EXPECT_FALSE(model.materials[plane.material].double_sided);
}

struct Solid {
  double volume = 0, area = 0;
  double normal_error = 0;  // largest distance of a vertex normal from that of its triangle
};

Solid solid_of(const Mesh& mesh) {
  Solid solid;
  for (const Surface& surface : mesh.surfaces) {
    for (size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
      const auto at = [&](size_t k) { return glm::dvec3(surface.positions[surface.indices[i + k]]); };
      const glm::dvec3 doubled = glm::cross(at(1) - at(0), at(2) - at(0));
      solid.volume += glm::dot(at(0), glm::cross(at(1), at(2))) / 6;
      solid.area += glm::length(doubled) / 2;
      for (size_t k = 0; k < 3; ++k)
        solid.normal_error = std::max(
            solid.normal_error,
            glm::length(glm::normalize(doubled) - glm::dvec3(surface.normals[surface.indices[i + k]])));
    }
  }
  return solid;
}

// A concave polygon of area 3, 2 m high: volume 6 by the divergence theorem.
TEST_F(Sdf, PolylinesArePrisms) {
  const Model model = read(shape(
      "<polyline><point>0 0</point><point>0 2</point><point>1 2</point><point>1 1</point><point>2 1</point>"
      "<point>2 0</point><height>2</height></polyline>"));
  EXPECT_NEAR(solid_of(model.meshes.front()).volume, 6, 1e-5);
}

// Even-odd, in any order and direction: a frame with a peg in its hole, which has a hole, too, and a block
// beside it. Areas: 16 - 4 + 1 - 0.25 and 2; walls: perimeters 16 + 8 + 4 + 2 and 6.
TEST_F(Sdf, PolylinesInsideOfOthersAreHoles) {
  const auto square = [](double x, double y, double half, bool clockwise, const char* height) {
    std::string points;
    for (int i = 0; i < 4; ++i) {
      const int k = clockwise ? 3 - i : i;
      points += "<point>" + std::to_string(x + (k == 0 || k == 3 ? -half : half)) + " " +
                std::to_string(y + (k < 2 ? -half : half)) + "</point>";
    }
    return "<polyline>" + points + "<height>" + height + "</height></polyline>";
  };
  const std::string block =
      "<polyline><point>9 0</point><point>10 0</point><point>10 2</point><point>9 2</point><height>3</height>"
      "</polyline>";
  for (const bool clockwise : {false, true}) {
    const Model model = read(shape(square(0, 0, 1, clockwise, "2") + square(0, 0, 2, true, "2") + block +
                                   square(0, 0, 0.25, !clockwise, "2") + square(0, 0, 0.5, clockwise, "2")));
    EXPECT_EQ(warnings(model), "");
    const Solid solid = solid_of(model.meshes.front());
    EXPECT_NEAR(solid.volume, 2 * 12.75 + 3 * 2, 1e-5);
    EXPECT_NEAR(solid.area, 2 * 12.75 + 2 * 30 + 2 * 2 + 3 * 6, 1e-5);
    EXPECT_LT(solid.normal_error, 1e-5);
  }
  const Model crossing = read(shape(square(0, 0, 1, false, "1") + square(0.9, 0.1, 0.5, false, "1")));
  EXPECT_NEAR(solid_of(crossing.meshes.front()).volume, 4 + 1, 1e-5);
}

TEST_F(Sdf, MeshScaleAndNode) {
  write("meshes/two.obj",
        "o first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no second\nv 4 0 0\nv 6 0 0\nv 4 2 0\nf 4 5 6\n");
  const auto range = [&](const std::string& more) {
    const Model model = read(shape("<mesh><uri>meshes/two.obj</uri><scale>2 2 2</scale>" + more + "</mesh>"));
    EXPECT_EQ(warnings(model), "");
    return bounds(surface(model, "m/l/v"));
  };
  expect_near(range("").first, {0, 0, 0});
  expect_near(range("").second, {12, 4, 0});
  expect_near(range("<submesh><name>second</name></submesh>").first, {8, 0, 0});
  expect_near(range("<submesh><name>second</name><center>true</center></submesh>").first, {-2, -2, 0});
  const Model model =
      read(shape("<mesh><uri>meshes/two.obj</uri><submesh><name>third</name></submesh></mesh>"));
  EXPECT_TRUE(warns(model, "has no node \"third\" with a mesh, only \"first\", \"second\""))
      << warnings(model);
}

TEST_F(Sdf, DaeSubmeshesAreFound) {
  std::string geometries, nodes;
  for (const std::string name : {"left", "right"}) {
    const std::string id = "g-" + name, x = name == "left" ? "0" : "5";
    geometries += "<geometry id='" + id + "' name='" + name + "'><mesh><source id='" + id +
                  "-p'><float_array id='" + id + "-a' count='9'>" + x + " 0 0 " + x + " 1 0 " + x +
                  " 0 2</float_array><technique_common><accessor source='#" + id +
                  "-a' count='3' stride='3'><param name='X' type='float'/><param name='Y' type='float'/>"
                  "<param name='Z' type='float'/></accessor></technique_common></source><vertices id='" +
                  id + "-v'><input semantic='POSITION' source='#" + id +
                  "-p'/></vertices><triangles count='1'><input semantic='VERTEX' source='#" + id +
                  "-v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry>";
    nodes += "<node" + std::string(name == "left" ? " id='n' name='first'" : "") +
             "><instance_geometry url='#" + id + "'/></node>";
  }
  write("pair.dae",
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        "<asset><up_axis>Y_UP</up_axis></asset><library_geometries>" +
            geometries + "</library_geometries><library_visual_scenes><visual_scene id='s'>" + nodes +
            "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
            "url='#s'/></scene></COLLADA>");
  const auto x_of = [&](const std::string& name) {
    const Model model =
        read(shape("<mesh><uri>pair.dae</uri><submesh><name>" + name + "</name></submesh></mesh>"));
    EXPECT_EQ(warnings(model), "");
    return bounds(surface(model, "m/l/v")).first.x;
  };
  EXPECT_EQ(x_of("first"), 0);
  EXPECT_EQ(x_of("left"), 0);
  EXPECT_EQ(x_of("right"), 5);
  // In the frame of the whole mesh, which is not turned.
  const auto size_of = [&](const std::string& more) {
    const Model model = read(shape("<mesh><uri>pair.dae</uri>" + more + "</mesh>"));
    const auto [low, high] = bounds(surface(model, "m/l/v"));
    return glm::dvec3(high - low);
  };
  expect_near(size_of(""), {5, 1, 2});
  expect_near(size_of("<submesh><name>left</name></submesh>"), {0, 1, 2});
}

TEST_F(Sdf, ColoursAreLinear) {
  const Model model = read(shape(kBox,
                                 "<transparency>0.5</transparency><material><diffuse>0.5 0.25 1 0.5</diffuse>"
                                 "<emissive>0 0.125 0 1</emissive></material>"));
  const Material& material = model.materials[surface(model, "m/l/v").material];
  EXPECT_EQ(material.base_color, glm::vec4(0.5f, 0.25f, 1, 0.25f));
  EXPECT_EQ(material.emission, glm::vec3(0, 0.125f, 0));
  EXPECT_TRUE(material.blended);
}

TEST_F(Sdf, FullTransparencyHasNoMesh) {
  const Model model = read(shape(kBox, "<transparency>1</transparency>"));
  ASSERT_TRUE(node(model, "m/l/v"));
  EXPECT_FALSE(node(model, "m/l/v")->mesh);
}

TEST_F(Sdf, WarningsAreLimited) {
  std::string visuals;
  for (int i = 0; i < 1200; ++i)
    visuals += visual("<sphere><radius>-1</radius></sphere>", "", "v" + std::to_string(i));
  const Model model = read(model_of("m", link("l", visuals)));
  EXPECT_TRUE(warns(model, "\"m/l/v999\"")) << model.warnings.size();
  EXPECT_FALSE(warns(model, "\"m/l/v1000\""));
  EXPECT_TRUE(warns(model, "further warnings are left out: there are more than 1000"));
}

TEST_F(Sdf, MaterialsAreThoseOfGazebo) {
  const auto material = [&](const std::string& text) {
    const Model model = read(shape(kBox, text));
    return model.materials[surface(model, "m/l/v").material];
  };
  EXPECT_EQ(material("").base_color, glm::vec4(0.7f, 0.7f, 0.7f, 1));
  EXPECT_EQ(material("").metallic, 1);
  EXPECT_EQ(material("<material/>").base_color, glm::vec4(0, 0, 0, 1));  // the format's default
  const std::string script = "<material><script><uri>file://x</uri><name>Gazebo/";
  EXPECT_EQ(material(script + "Orange</name></script></material>").base_color,
            glm::vec4(1, 0.5088f, 0.0468f, 1));
  EXPECT_EQ(material(script + "RedGlow</name></script></material>").emission, glm::vec3(1, 0, 0));
  EXPECT_EQ(material(script + "Unheard</name></script></material>").base_color,
            glm::vec4(0.7f, 0.7f, 0.7f, 1));
  EXPECT_TRUE(warns(read(shape(kBox, script + "Unheard</name></script></material>")), "Gazebo/Unheard"));
}

TEST_F(Sdf, MetallicRoughnessIsPacked) {
  const auto grey = [](uint8_t level) { return std::vector<uint8_t>{level, level, level}; };
  const auto png = [&](uint8_t level) { return png_of(grey(level), 1, 1, 3); };
  const auto metal = png(51), rough = png(204), albedo = png_of(std::vector<uint8_t>{1, 2, 3, 4}, 1, 1, 4);
  ASSERT_TRUE(metal.ok() && rough.ok() && albedo.ok());
  const auto text = [](const std::vector<std::byte>& bytes) {
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  write("m.png", text(*metal));
  write("r.png", text(*rough));
  write("a.png", text(*albedo));
  const Model model =
      read(shape(kBox,
                 "<material><diffuse>1 1 1 1</diffuse><pbr><metal><albedo_map>a.png</albedo_map>"
                 "<metalness>0.25</metalness><metalness_map>m.png</metalness_map>"
                 "<roughness_map>r.png</roughness_map><normal_map>r.png</normal_map>"
                 "<ambient_occlusion_map>r.png</ambient_occlusion_map>"
                 "<emissive_map>m.png</emissive_map></metal></pbr></material>"));
  EXPECT_EQ(warnings(model), "");
  const Material& material = model.materials[surface(model, "m/l/v").material];
  EXPECT_EQ(material.metallic, 0.25f);
  EXPECT_EQ(material.roughness, 0.5f);  // the format's default
  EXPECT_EQ(material.alpha_cutoff, 0.5f);
  EXPECT_EQ(material.emission, glm::vec3(1));
  ASSERT_TRUE(material.metallic_roughness_image && material.base_color_image && material.occlusion_image);
  EXPECT_EQ(model.images[*material.normal_image].name, "r.png");
  EXPECT_EQ(material.occlusion_image, material.normal_image);
  const auto expected = png_of(std::vector<uint8_t>{255, 204, 51}, 1, 1, 3);
  EXPECT_EQ(model.images[*material.metallic_roughness_image].bytes, *expected);
}

// Units: docs/convert.md.
TEST_F(Sdf, LightsHaveCandelaAndLux) {
  const auto light = [&](const std::string& type, const std::string& inside) {
    const Model model = read("<light name='l' type='" + type + "'>" + inside + "</light>");
    EXPECT_EQ(model.lights.size(), 1u);
    return model.lights.empty() ? Light() : model.lights[0];
  };
  const float pi = std::numbers::pi_v<float>;
  const std::string color = "<diffuse>0.5 0.25 0 1</diffuse>";
  const Light sun = light("directional", color + "<intensity>4</intensity>");
  EXPECT_EQ(sun.type, Light::Type::directional);
  EXPECT_FLOAT_EQ(sun.intensity, 2 * pi);
  EXPECT_EQ(sun.color, glm::vec3(1, 0.5f, 0));
  const std::string quadratic =
      "<attenuation><range>9</range><constant>0</constant><linear>0</linear><quadratic>2</quadratic></"
      "attenuation>";
  EXPECT_FLOAT_EQ(light("point", color + quadratic).intensity, 0.25f * pi);
  const std::string mixed =
      "<attenuation><range>9</range><constant>1</constant><linear>0.5</linear><quadratic>0.5</quadratic></"
      "attenuation>";
  EXPECT_FLOAT_EQ(light("point", color + mixed).intensity, 0.25f * pi);
  const Light spot = light("spot", quadratic +
                                       "<spot><inner_angle>0.6</inner_angle><outer_angle>1</outer_angle>"
                                       "<falloff>1</falloff></spot>");
  EXPECT_FLOAT_EQ(spot.outer_cone_rad, 0.5f);
  EXPECT_FLOAT_EQ(spot.inner_cone_rad, 0.3f);
}

TEST_F(Sdf, LightsShineAlongTheirDirection) {
  const Model model = read(
      "<light name='sun' type='directional'><pose>0 0 5 0 0 1.5707963267948966</pose>"
      "<direction>1 0 0</direction></light>");
  expect_near(-glm::dvec3(pose_of(model, "sun#light")[2]), {0, 1, 0});
  expect_near(glm::dvec3(pose_of(model, "sun")[3]), {0, 0, 5});
}

TEST_F(Sdf, CamerasLookAlongX) {
  const std::string camera =
      "<sensor name='c' type='camera'><pose>1 0 0 0 0 0</pose><camera><horizontal_fov>1.5707963267948966"
      "</horizontal_fov><image><width>400</width><height>200</height></image><clip><near>0.2</near><far>50</"
      "far>"
      "</clip>";
  const Model model = read(model_of("m", link("l", camera + "</camera></sensor>")));
  ASSERT_EQ(model.cameras.size(), 2u);  // the first is where Gazebo's window starts
  EXPECT_EQ(model.cameras[1].name, "m/l/c");
  EXPECT_NEAR(model.cameras[1].vertical_fov_rad, 2 * std::atan(0.5), 1e-6);
  EXPECT_EQ(model.cameras[1].aspect, 2.0f);
  EXPECT_EQ(model.cameras[1].near_m, 0.2f);
  EXPECT_EQ(model.cameras[1].far_m, 50.0f);
  const glm::dmat4 view = pose_of(model, "m/l/c#view");
  expect_near(glm::dvec3(view[3]), {1, 0, 0});
  expect_near(-glm::dvec3(view[2]), {1, 0, 0});  // forward
  expect_near(glm::dvec3(view[1]), {0, 0, 1});   // up
  // fy = 100 pixels of a height of 200.
  const Model focal = read(model_of(
      "m",
      link("l", camera +
                    "<lens><intrinsics><fx>50</fx><fy>100</fy><cx>160</cx><cy>130</cy></intrinsics></lens>"
                    "<distortion><k1>0.1</k1></distortion></camera></sensor>")));
  ASSERT_EQ(focal.cameras.size(), 2u);
  EXPECT_NEAR(focal.cameras[1].vertical_fov_rad, kQuarter, 1e-6);
  EXPECT_NEAR(focal.cameras[1].pixel_aspect, 2, 1e-6);
  EXPECT_NEAR(focal.cameras[1].principal_point.x, -0.2, 1e-6);
  EXPECT_NEAR(focal.cameras[1].principal_point.y, 0.15, 1e-6);
  EXPECT_TRUE(warns(focal, "its <distortion> is not drawn")) << warnings(focal);
}

TEST_F(Sdf, ViewsStartWhereGazebosWindowDoes) {
  const auto start = [&](const std::string& gui) {
    const Model model = read(gui + shape(kBox));
    EXPECT_EQ(warnings(model), "");
    return node(model, "gui camera") ? pose_of(model, "gui camera") : glm::dmat4(0);
  };
  EXPECT_EQ(start(""), glm::dmat4(0));
  const std::string pose = "1 2 3 0 0 1.5707963267948966";
  for (const std::string& gui :
       {"<gui><camera name='c'><pose>" + pose + "</pose></camera></gui>",
        "<gui><plugin name='a' filename='b'/><plugin name='3D View' filename='MinimalScene'><camera_pose>" +
            pose + "</camera_pose></plugin></gui>"}) {
    const glm::dmat4 view = start(gui);
    expect_near(glm::dvec3(view[3]), {1, 2, 3});
    expect_near(-glm::dvec3(view[2]), {0, 1, 0});  // forward: X of the pose
  }
}

TEST_F(Sdf, ModelFilesAndFoldersAreRead) {
  const std::string text =
      "<sdf version='1.6'><model name='crate'>" + link("l", visual(kBox)) + "</model></sdf>";
  const auto alone = read_description(write("models/crate/model.sdf", text), {});
  ASSERT_TRUE(alone.ok()) << alone.error().message;
  EXPECT_TRUE(node(*alone, "crate/l/v"));
  write(
      "models/crate/model.config",
      "<model><name>crate</name><sdf version='1.5'>old.sdf</sdf><sdf version='1.6'>model.sdf</sdf></model>");
  const auto folder = read_description(folder_.path() / "models/crate", {});
  ASSERT_TRUE(folder.ok()) << folder.error().message;
  EXPECT_TRUE(node(*folder, "crate/l/v"));
  const auto none = read_description(folder_.path() / "models", {});
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("has no model.config"), std::string::npos) << none.error().message;
}

TEST_F(Sdf, WhatIsNotDrawnIsSaid) {
  const Model model =
      read("<actor name='walker'><skin><filename>a.dae</filename></skin></actor>" +
           model_of("m", link("l", visual("<heightmap><uri>h.png</uri></heightmap>") +
                                       visual(kBox, "<cast_shadows>false</cast_shadows>", "b"))));
  EXPECT_TRUE(warns(model, "actor \"walker\" is left out")) << warnings(model);
  EXPECT_TRUE(warns(model, "visual \"m/l/v\": its <heightmap> is not drawn")) << warnings(model);
  EXPECT_TRUE(warns(model, "1 visual without <cast_shadows>")) << warnings(model);
}

}  // namespace
}  // namespace fire3dv::convert

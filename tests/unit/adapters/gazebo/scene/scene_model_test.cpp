// Conversion of Gazebo's scenes: shapes, materials, lights, cameras, and files found by URI.
#include "adapters/gazebo/scene/scene_model.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "convert/description_files.h"
#include "convert/glb/write_glb.h"
#include "convert/sdf/files/sdf_files.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::gazebo {
namespace {

namespace fs = std::filesystem;
constexpr double kPi = std::numbers::pi;

// One model with one link.
struct OneLink {
  pb::Scene scene;
  pb::Link* link = nullptr;
  OneLink() {
    pb::Model& model = *scene.add_model();
    model.set_name("m");
    link = model.add_link();
    link->set_name("l");
  }
  pb::Visual& add(int type, const std::string& name = "v") {
    pb::Visual& visual = *link->add_visual();
    visual.set_name(name);
    visual.mutable_geometry()->set_type(type);
    return visual;
  }
  convert::Model convert(const std::vector<fs::path>& resource_folders = {}) const {
    std::vector<std::string> warnings;
    std::vector<TopLevel> items = read_entities(scene, warnings);
    std::vector<TopLevel*> all;
    for (TopLevel& item : items) all.push_back(&item);
    convert::SdfNames names;
    name_entities(all, names);
    return scene_model(items, resource_folders, "world");
  }
};

const convert::Node* find(const convert::Model& model, const std::string& name) {
  for (const convert::Node& node : model.nodes)
    if (node.name == name) return &node;
  return nullptr;
}

glm::dvec3 extent(const convert::Mesh& mesh) {
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const convert::Surface& surface : mesh.surfaces)
    for (const glm::vec3& p : surface.positions) low = glm::min(low, p), high = glm::max(high, p);
  return high - low;
}

// Six times the volume that a closed, outward surface encloses is the sum of these determinants.
double volume(const convert::Mesh& mesh) {
  double sum = 0;
  for (const convert::Surface& surface : mesh.surfaces) {
    for (size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
      const glm::dvec3 a(surface.positions[surface.indices[i]]), b(surface.positions[surface.indices[i + 1]]),
          c(surface.positions[surface.indices[i + 2]]);
      sum += glm::dot(a, glm::cross(b, c));
    }
  }
  return sum / 6;
}

TEST(GazeboScene, HasShapesOfRightSize) {
  OneLink world;
  pb::Vector3d& size = *world.add(0, "box").mutable_geometry()->mutable_box()->mutable_size();
  size.set_x(1), size.set_y(2), size.set_z(3);
  pb::CylinderGeom& cylinder = *world.add(1, "cylinder").mutable_geometry()->mutable_cylinder();
  cylinder.set_radius(0.5), cylinder.set_length(2);
  world.add(2, "sphere").mutable_geometry()->mutable_sphere()->set_radius(1.5);
  pb::CylinderGeom& cone = *world.add(10, "cone").mutable_geometry()->mutable_cone();
  cone.set_radius(1), cone.set_length(3);
  pb::CylinderGeom& capsule = *world.add(14, "capsule").mutable_geometry()->mutable_capsule();
  capsule.set_radius(0.5), capsule.set_length(2);
  pb::Vector3d& radii = *world.add(15, "ellipsoid").mutable_geometry()->mutable_ellipsoid()->mutable_radii();
  radii.set_x(1), radii.set_y(2), radii.set_z(0.5);
  pb::Polyline& prism = *world.add(9, "prism").mutable_geometry()->add_polyline();
  prism.set_height(2);
  for (const glm::dvec2 at : {glm::dvec2(0, 0), {3, 0}, {3, 1}, {0, 1}}) {
    pb::Vector2d& point = *prism.add_point();
    point.set_x(at.x), point.set_y(at.y);
  }
  const convert::Model model = world.convert();
  EXPECT_TRUE(model.warnings.empty());
  const struct {
    const char* name;
    glm::dvec3 extent;
    double volume;
  } shapes[] = {{"box", {1, 2, 3}, 6},
                {"cylinder", {1, 1, 2}, kPi * 0.25 * 2},
                {"sphere", {3, 3, 3}, 4 * kPi / 3 * 3.375},
                {"cone", {2, 2, 3}, kPi},
                {"capsule", {1, 1, 3}, kPi * 0.25 * 2 + 4 * kPi / 3 * 0.125},
                {"ellipsoid", {2, 4, 1}, 4 * kPi / 3},
                {"prism", {3, 1, 2}, 6}};
  for (const auto& shape : shapes) {
    const convert::Node* node = find(model, std::string("m/l/") + shape.name);
    ASSERT_TRUE(node && node->mesh) << shape.name;
    const convert::Mesh& mesh = model.meshes[*node->mesh];
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(extent(mesh)[axis], shape.extent[axis], 0.02) << shape.name;
    EXPECT_NEAR(volume(mesh), shape.volume, 0.03 * shape.volume) << shape.name;
  }
  EXPECT_TRUE(convert::write_glb(model));
}

TEST(GazeboScene, TurnsPlanesToTheirNormal) {
  for (const glm::dvec3 normal : {glm::dvec3(0, 0, 1), {1, 0, 0}, {0, -2, 0}, {0, 0, -1}}) {
    OneLink world;
    pb::PlaneGeom& plane = *world.add(3).mutable_geometry()->mutable_plane();
    plane.mutable_size()->set_x(4), plane.mutable_size()->set_y(2);
    plane.mutable_normal()->set_x(normal.x), plane.mutable_normal()->set_y(normal.y),
        plane.mutable_normal()->set_z(normal.z);
    const convert::Model model = world.convert();
    ASSERT_EQ(model.meshes.size(), 1u);
    for (const glm::vec3& n : model.meshes[0].surfaces[0].normals)
      EXPECT_NEAR(glm::length(glm::dvec3(n) - glm::normalize(normal)), 0, 1e-6);
    EXPECT_NEAR(glm::dot(extent(model.meshes[0]), glm::abs(glm::normalize(normal))), 0, 1e-6);
  }
}

TEST(GazeboScene, LeavesImpossibleShapesOut) {
  OneLink world;
  world.add(0, "no size");
  world.add(2, "nan").mutable_geometry()->mutable_sphere()->set_radius(NAN);
  world.add(1, "huge").mutable_geometry()->mutable_cylinder()->set_radius(1e30);
  world.add(5, "heightmap");
  world.add(777, "unknown");
  world.add(6, "mesh").mutable_geometry()->mutable_mesh()->set_filename("model://nowhere/mesh.dae");
  const convert::Model model = world.convert();
  EXPECT_TRUE(model.meshes.empty());
  ASSERT_EQ(model.warnings.size(), 6u);
  EXPECT_NE(model.warnings[5].find("--resource-path"), std::string::npos) << model.warnings[5];
  EXPECT_TRUE(convert::write_glb(model));
}

TEST(GazeboScene, HasMaterialsAndTransparency) {
  OneLink world;
  world.add(2, "grey").mutable_geometry()->mutable_sphere()->set_radius(1);
  pb::Visual& red = world.add(2, "red");
  red.mutable_geometry()->mutable_sphere()->set_radius(2);
  red.mutable_material()->mutable_diffuse()->set_r(0.5f);
  red.mutable_material()->mutable_diffuse()->set_a(0.5f);
  red.mutable_material()->mutable_pbr()->set_type(1);
  red.mutable_material()->mutable_pbr()->set_roughness(0.25);
  red.mutable_material()->mutable_pbr()->set_metalness(0.75);
  red.set_transparency(0.5);
  pb::Visual& hidden = world.add(2, "hidden");
  hidden.mutable_geometry()->mutable_sphere()->set_radius(3);
  hidden.set_transparency(1);
  const convert::Model model = world.convert();
  ASSERT_EQ(model.meshes.size(), 2u);
  const convert::Material& grey = model.materials[model.meshes[0].surfaces[0].material];
  EXPECT_EQ(grey.base_color, glm::vec4(0.7f, 0.7f, 0.7f, 1));
  EXPECT_EQ(grey.metallic, 1);
  const convert::Material& of_red = model.materials[model.meshes[1].surfaces[0].material];
  EXPECT_EQ(of_red.base_color, glm::vec4(0.5f, 0, 0, 0.25f));
  EXPECT_TRUE(of_red.blended);
  EXPECT_EQ(of_red.roughness, 0.25f);
  EXPECT_EQ(of_red.metallic, 0.75f);
}

// As of SDF files: planes are seen from their normal only, all other shapes from both sides.
TEST(GazeboScene, MaterialsAreDoubleSided) {
  OneLink world;
  for (const bool is_double_sided : {false, true}) {
    pb::Visual& plane = world.add(3, is_double_sided ? "both" : "one");
    plane.mutable_geometry()->mutable_plane()->mutable_size()->set_x(1);
    plane.mutable_geometry()->mutable_plane()->mutable_size()->set_y(is_double_sided ? 2 : 1);
    plane.mutable_material()->set_double_sided(is_double_sided);
  }
  world.add(2, "ball").mutable_geometry()->mutable_sphere()->set_radius(1);
  const convert::Model model = world.convert();
  ASSERT_EQ(model.meshes.size(), 3u);
  const auto is_double_sided = [&](size_t mesh) {
    return model.materials[model.meshes[mesh].surfaces[0].material].double_sided;
  };
  EXPECT_FALSE(is_double_sided(0));
  EXPECT_TRUE(is_double_sided(1));
  EXPECT_TRUE(is_double_sided(2));
}

TEST(GazeboScene, ScriptAndSpecularMaterialsAreRead) {
  OneLink world;
  pb::Visual& script = world.add(2, "script");
  script.mutable_geometry()->mutable_sphere()->set_radius(1);
  script.mutable_material()->mutable_script()->set_name("Gazebo/Orange");
  pb::Visual& specular = world.add(2, "specular");
  specular.mutable_geometry()->mutable_sphere()->set_radius(2);
  specular.mutable_material()->mutable_pbr()->set_type(2);
  specular.mutable_material()->mutable_pbr()->set_glossiness(0.75);
  specular.mutable_material()->mutable_pbr()->set_light_map("baked.png");
  const convert::Model model = world.convert();
  ASSERT_EQ(model.meshes.size(), 2u);
  EXPECT_EQ(model.materials[model.meshes[0].surfaces[0].material].base_color,
            glm::vec4(1, 0.5088f, 0.0468f, 1));
  EXPECT_EQ(model.materials[model.meshes[1].surfaces[0].material].roughness, 0.25f);
  EXPECT_EQ(model.materials[model.meshes[1].surfaces[0].material].metallic, 0);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_EQ(model.warnings[0], "visual \"m/l/specular\": its <light_map> is not used");
}

TEST(GazeboScene, HasLightsAndCameras) {
  OneLink world;
  pb::Light& sun = *world.scene.add_light();
  sun.set_name("sun");
  sun.set_type(2);
  sun.set_intensity(2);
  sun.mutable_diffuse()->set_r(1);
  sun.mutable_direction()->set_x(1);
  pb::Light& spot = *world.link->add_light();
  spot.set_name("spot");
  spot.set_type(1);
  spot.set_intensity(1);
  spot.mutable_diffuse()->set_g(1);
  spot.set_attenuation_quadratic(0.5f);
  spot.set_spot_inner_angle(0.4f);
  spot.set_spot_outer_angle(0.8f);
  world.scene.add_light()->set_name("dark");
  pb::Light& off = *world.scene.add_light();
  off.set_name("off");
  off.set_type(2);
  off.set_intensity(1);
  off.mutable_diffuse()->set_r(1);
  off.set_is_light_off(true);
  pb::Light& bright = *world.scene.add_light();
  bright.set_name("bright");
  bright.set_type(2);
  bright.set_intensity(1);
  bright.mutable_diffuse()->set_r(4);
  bright.mutable_diffuse()->set_g(1);
  pb::Sensor& sensor = *world.link->add_sensor();
  sensor.set_name("eye");
  sensor.set_type("camera");
  sensor.mutable_camera()->set_horizontal_fov(kPi / 2);
  sensor.mutable_camera()->mutable_image_size()->set_x(200);
  sensor.mutable_camera()->mutable_image_size()->set_y(100);
  sensor.mutable_camera()->set_near_clip(0.5);
  world.link->add_sensor()->set_type("imu");
  pb::Sensor& broken = *world.link->add_sensor();
  broken.set_name("broken");
  broken.set_type("camera");
  broken.mutable_camera()->set_horizontal_fov(NAN);
  const convert::Model model = world.convert();
  // Dark lights stay, so that a world whose only light is dark gets no other one.
  ASSERT_EQ(model.lights.size(), 5u);
  EXPECT_EQ(model.lights[*find(model, "dark#light")->light].intensity, 0);
  EXPECT_EQ(model.lights[*find(model, "off#light")->light].intensity, 0);
  const convert::Light& of_bright = model.lights[*find(model, "bright#light")->light];
  EXPECT_EQ(of_bright.color, glm::vec3(1, 0.25f, 0));
  EXPECT_NEAR(static_cast<double>(of_bright.intensity), 4 * kPi, 1e-4);
  ASSERT_EQ(model.warnings.size(), 2u);
  EXPECT_EQ(model.warnings[0].find("camera \"m/l/broken\" is left out"), 0u) << model.warnings[0];
  EXPECT_EQ(model.warnings[1].find("light \"dark\" is dark"), 0u) << model.warnings[1];
  const convert::Node* of_sun = find(model, "sun#light");
  ASSERT_TRUE(of_sun && of_sun->light);
  EXPECT_EQ(model.nodes[*of_sun->parent].name, "sun");
  EXPECT_NEAR(glm::length(of_sun->rotation * glm::dvec3(0, 0, -1) - glm::dvec3(1, 0, 0)), 0, 1e-9);
  EXPECT_NEAR(static_cast<double>(model.lights[*of_sun->light].intensity), 2 * kPi, 1e-4);  // lux
  const convert::Light& of_spot = model.lights[*find(model, "m/l/spot#light")->light];
  EXPECT_NEAR(static_cast<double>(of_spot.intensity), kPi / 0.5, 1e-4);  // candela
  EXPECT_FLOAT_EQ(of_spot.outer_cone_rad, 0.4f);
  EXPECT_FLOAT_EQ(of_spot.inner_cone_rad, 0.2f);
  const convert::Node* view = find(model, "m/l/eye#view");
  ASSERT_TRUE(view && view->camera);
  EXPECT_NEAR(glm::length(view->rotation * glm::dvec3(0, 0, -1) - glm::dvec3(1, 0, 0)), 0,
              1e-9);  // looks along +X
  EXPECT_NEAR(glm::length(view->rotation * glm::dvec3(0, 1, 0) - glm::dvec3(0, 0, 1)), 0, 1e-9);  // Z up
  EXPECT_NEAR(static_cast<double>(model.cameras[0].vertical_fov_rad), 2 * std::atan(0.5), 1e-6);
  EXPECT_EQ(model.cameras.size(), 1u);
}

class GazeboFiles : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    return path;
  }
  // A file that a mesh or image may be.
  Result<fs::path> find(const std::vector<fs::path>& folders, const std::string& uri) {
    const Result<fs::path> found = convert::SdfFiles(folders, "--resource-path").resolve(uri, {});
    return found ? convert::regular_file(*found) : found;
  }
  test::ScratchFolder folder_;
};

TEST_F(GazeboFiles, AreFoundByUri) {
  const fs::path mesh = write("models/cart/meshes/cart.obj", "v 0 0 0\n");
  for (const std::string& uri :
       {std::string("model://cart/meshes/cart.obj"), std::string("package://cart/meshes/cart.obj"),
        "file://" + mesh.string(), mesh.string(), std::string("cart/meshes/cart.obj"),
        std::string("/home/somebody/ws/cart/meshes/cart.obj")}) {
    const Result<fs::path> found = find({folder_.path() / "models"}, uri);
    ASSERT_TRUE(found) << uri << ": " << found.error().message;
    EXPECT_TRUE(fs::equivalent(*found, mesh)) << uri;
  }
  // The folder of the model itself.
  EXPECT_TRUE(find({folder_.path() / "models" / "cart"}, "model://cart/meshes/cart.obj"));
}

TEST_F(GazeboFiles, DoNotLeaveTheirFolders) {
  write("secret", "x");
  write("models/a/b", "x");
  for (const char* uri :
       {"model://../secret", "model://a/../../secret", "model://", "model://a", "ftp://a/b", "", "../secret",
        "/far/../secret",
        "https://fuel.gazebosim.org/1.0/o/models/m/1/files/../../../../../../../etc/passwd"})
    EXPECT_FALSE(find({folder_.path() / "models"}, uri)) << uri;
  EXPECT_FALSE(find({}, "gazebo_scene_test.cpp"));  // beside no file
  // Absolute paths, which whoever reaches the network may name.
  const std::string root = folder_.path().string();
  write("models2/b", "x");
  for (const std::string& outside :
       {root + "/secret", "file://" + root + "/secret", root + "/models/../secret", root + "/models2/b"}) {
    const Result<fs::path> found = find({folder_.path() / "models"}, outside);
    ASSERT_FALSE(found) << outside;
    EXPECT_NE(found.error().message.find("outside the folders"), std::string::npos) << found.error().message;
    EXPECT_NE(found.error().message.find("--resource-path"), std::string::npos);
  }
  for (const char* folder : {"models", "models/", "models2/../models", "models/a"})
    EXPECT_TRUE(find({folder_.path() / folder}, root + "/models//a/./b")) << folder;
  EXPECT_TRUE(find({folder_.path() / "models2"}, root + "/models2/b"));
  // Links are the user's.
  fs::create_symlink(folder_.path() / "secret", folder_.path() / "models/link");
  EXPECT_TRUE(find({folder_.path() / "models"}, root + "/models/link"));
  const Result<fs::path> endless = find({folder_.path() / "models"}, "/" + std::string(100'000, 'a') + "/b");
  ASSERT_FALSE(endless);
  EXPECT_LT(endless.error().message.size(), 200u);
}

TEST_F(GazeboFiles, AreFoundInFuelCache) {
  for (const char* version : {"2", "10", "9"})
    write(
        std::string("cache/fuel.gazebosim.org/openrobotics/models/gas station/") + version + "/meshes/m.dae",
        version);
  setenv("GZ_FUEL_CACHE_PATH", (folder_.path() / "cache").c_str(), 1);
  convert::SdfFiles files({}, "--resource-path");
  unsetenv("GZ_FUEL_CACHE_PATH");
  const fs::path models = folder_.path() / "cache/fuel.gazebosim.org/openrobotics/models/gas station";
  const auto check = [&](const std::string& uri, const std::string& version) {
    const Result<fs::path> found = files.resolve(uri, {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(*found, models / version / "meshes/m.dae");
  };
  check("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Gas Station/2/files/meshes/m.dae", "2");
  check("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Gas Station/tip/files/meshes/m.dae", "10");
  check("https://fuel.gazebosim.org/OpenRobotics/models/Gas Station/files/meshes/m.dae", "10");
  check("model://Gas Station/meshes/m.dae", "10");
  const Result<fs::path> missing =
      files.resolve("https://fuel.gazebosim.org/1.0/OpenRobotics/models/Other/1/files/a", {});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("nothing is downloaded"), std::string::npos);
}

TEST_F(GazeboFiles, GiveMeshesAndTextures) {
  write("models/cart/model.config", "<model/>");
  write("models/cart/meshes/cart.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  const std::vector<uint8_t> pixels = {255, 0, 0};
  const std::vector<std::byte> png = *convert::png_of(pixels, 1, 1, 3);
  write("models/cart/materials/red.png", std::string(reinterpret_cast<const char*>(png.data()), png.size()));
  write("elsewhere/red.png", std::string(reinterpret_cast<const char*>(png.data()), png.size()));
  OneLink world;
  pb::Visual& visual = world.add(6, "textured");
  pb::MeshGeom& mesh = *visual.mutable_geometry()->mutable_mesh();
  mesh.set_filename((folder_.path() / "models/cart/meshes/cart.obj").string());
  mesh.mutable_scale()->set_x(2), mesh.mutable_scale()->set_y(3), mesh.mutable_scale()->set_z(1);
  visual.mutable_material()->mutable_diffuse()->set_r(1);
  visual.mutable_material()->mutable_diffuse()->set_a(1);
  visual.mutable_material()->mutable_pbr()->set_type(1);
  visual.mutable_material()->mutable_pbr()->set_albedo_map(
      (folder_.path() / "models/cart/materials/red.png").string());
  pb::Visual& outside = world.add(2, "outside");
  outside.mutable_geometry()->mutable_sphere()->set_radius(1);
  *outside.mutable_material() = visual.material();
  outside.mutable_material()->mutable_pbr()->set_albedo_map((folder_.path() / "elsewhere/red.png").string());
  const convert::Model model = world.convert({folder_.path() / "models"});
  ASSERT_EQ(model.meshes.size(), 2u);
  EXPECT_EQ(extent(model.meshes[0]), glm::dvec3(2, 3, 0));
  EXPECT_EQ(model.images.size(), 1u);
  EXPECT_EQ(model.materials[model.meshes[0].surfaces[0].material].base_color_image, 0u);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("elsewhere"), std::string::npos);
  EXPECT_NE(model.warnings[0].find("--resource-path"), std::string::npos);
}

// As of SDF files: an albedo map with opacity cuts, occlusion is the map's, and a scale of 0 is invisible.
TEST_F(GazeboFiles, SdfRulesLimitFiles) {
  const std::vector<uint8_t> pixels = {255, 0, 0, 128};
  const std::vector<std::byte> png = *convert::png_of(pixels, 1, 1, 4);
  write("models/cart/map.png", std::string(reinterpret_cast<const char*>(png.data()), png.size()));
  write("models/cart/cart.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  OneLink world;
  pb::Visual& visual = world.add(2, "cut");
  visual.mutable_geometry()->mutable_sphere()->set_radius(1);
  visual.mutable_material()->mutable_diffuse()->set_r(1);
  visual.mutable_material()->mutable_diffuse()->set_a(1);
  visual.mutable_material()->mutable_pbr()->set_type(1);
  visual.mutable_material()->mutable_pbr()->set_albedo_map("model://cart/map.png");
  visual.mutable_material()->mutable_pbr()->set_ambient_occlusion_map("model://cart/map.png");
  pb::Visual& flat = world.add(6, "flat");
  flat.mutable_geometry()->mutable_mesh()->set_filename("model://cart/cart.obj");
  flat.mutable_geometry()->mutable_mesh()->mutable_scale()->set_x(1);
  const convert::Model model = world.convert({folder_.path() / "models"});
  ASSERT_EQ(model.meshes.size(), 1u);
  const convert::Material& cut = model.materials[model.meshes[0].surfaces[0].material];
  EXPECT_EQ(cut.alpha_cutoff, 0.5f);
  ASSERT_TRUE(cut.base_color_image);
  EXPECT_EQ(cut.occlusion_image, cut.base_color_image);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_EQ(model.warnings[0].find("visual \"m/l/flat\" is left out: a <scale> of 0"), 0u);
}

// One geometry of a DAE file with Y up, which Gazebo does not turn.
std::string dae_geometry(const std::string& name, const std::string& x) {
  const std::string id = "g-" + name;
  return "<geometry id='" + id + "' name='" + name + "'><mesh><source id='" + id + "-p'><float_array id='" +
         id + "-a' count='9'>" + x + " 0 0 " + x + " 1 0 " + x +
         " 0 2</float_array><technique_common><accessor source='#" + id +
         "-a' count='3' stride='3'><param name='X' type='float'/><param name='Y' type='float'/>"
         "<param name='Z' type='float'/></accessor></technique_common></source><vertices id='" +
         id + "-v'><input semantic='POSITION' source='#" + id +
         "-p'/></vertices><triangles count='1'><input semantic='VERTEX' source='#" + id +
         "-v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry>";
}

TEST_F(GazeboFiles, SubmeshesKeepMeshFrame) {
  write("models/pair/pair.dae",
        "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        "<asset><up_axis>Y_UP</up_axis></asset><library_geometries>" +
            dae_geometry("left", "0") + dae_geometry("right", "5") +
            "</library_geometries><library_visual_scenes><visual_scene id='s'><node id='n' name='first'>"
            "<instance_geometry url='#g-left'/></node><node><instance_geometry url='#g-right'/></node>"
            "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
            "url='#s'/></scene></COLLADA>");
  const auto box = [&](const std::string& submesh, bool is_centred = false) {
    OneLink world;
    pb::MeshGeom& mesh = *world.add(6).mutable_geometry()->mutable_mesh();
    mesh.set_filename("model://pair/pair.dae");
    mesh.set_submesh(submesh);
    mesh.set_center_submesh(is_centred);
    const convert::Model model = world.convert({folder_.path() / "models"});
    glm::vec3 low(INFINITY), high(-INFINITY);
    EXPECT_TRUE(model.warnings.empty()) << model.warnings[0];
    for (const convert::Mesh& each : model.meshes)
      for (const convert::Surface& surface : each.surfaces)
        for (const glm::vec3& p : surface.positions) low = glm::min(low, p), high = glm::max(high, p);
    return std::pair(low, high);
  };
  EXPECT_EQ(box(""), std::pair(glm::vec3(0), glm::vec3(5, 1, 2)));
  EXPECT_EQ(box("first"), std::pair(glm::vec3(0), glm::vec3(0, 1, 2)));  // a node
  EXPECT_EQ(box("left"), std::pair(glm::vec3(0), glm::vec3(0, 1, 2)));   // a geometry
  EXPECT_EQ(box("right"), std::pair(glm::vec3(5, 0, 0), glm::vec3(5, 1, 2)));
  EXPECT_EQ(box("right", true), std::pair(glm::vec3(0, -0.5f, -1), glm::vec3(0, 0.5f, 1)));
  OneLink world;
  pb::MeshGeom& mesh = *world.add(6).mutable_geometry()->mutable_mesh();
  mesh.set_filename("model://pair/pair.dae");
  mesh.set_submesh("third");
  const convert::Model model = world.convert({folder_.path() / "models"});
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("has no node \"third\" with a mesh"), std::string::npos)
      << model.warnings[0];
}

}  // namespace
}  // namespace fire3dv::gazebo

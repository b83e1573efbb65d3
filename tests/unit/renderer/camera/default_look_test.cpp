// Test of the default look's choices: key light, exposure estimate, ground, camera start, empty images.
#include "renderer/camera/default_look.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "renderer/scene/derived/key_light.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/exposure_estimate.h"
#include "renderer/scene/textures/environment.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

scene::Scene built(SceneBuilder builder) {
  scene::Scene scene = builder.build();
  scene::find_world_bounds(scene);
  return scene;
}

SceneBuilder box_builder(const scene::Material& material = matte({0.5f, 0.5f, 0.5f})) {
  SceneBuilder builder;
  builder.mesh_node("box", builder.box(builder.material(material), {1, 2, 1}), at({0, 3, 0}));
  return builder;
}

TEST(KeyLight, LightlessScenesGetAKeyLight) {
  scene::Scene scene = built(box_builder());
  const size_t nodes = scene.nodes.size();
  scene::add_key_light(scene);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.nodes.back().name, "key light");
  EXPECT_LT(-scene.nodes.back().world_from_node[2].y, -0.7f) << "it shines downwards, along -Z of its node";
  EXPECT_TRUE(scene::check_scene(scene).ok());
  scene::add_key_light(scene);
  EXPECT_EQ(scene.lights.size(), 1u);
  scene::remove_key_light(scene);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_EQ(scene.nodes.size(), nodes);

  SceneBuilder lit = box_builder();
  lit.light_node(sun({1, 1, 1}, 2), shining_towards({0, -1, 0}));
  scene::Scene own = lit.build();
  scene::add_key_light(own);
  scene::remove_key_light(own);
  EXPECT_EQ(own.lights.size(), 1u) << "the file's own light stays";
}

scene::SeenFrom default_view(const scene::Scene& scene) {
  const passes::View view = app::CameraRig::create(scene)->view(state::PoseState(scene), 4.0f / 3);
  return {view.clip_from_world, glm::vec4(view.eye_world, 1)};
}

scene::ExposureEstimate estimate(const scene::Scene& scene, float environment_radiance) {
  return scene::estimate_exposure(scene, environment_radiance, [&] { return default_view(scene); });
}

scene::Light bulb(float candela) {
  scene::Light light;
  light.intensity = candela;
  return light;
}

TEST(ExposureEstimate, ExtremeScenesAreScaled) {
  EXPECT_EQ(estimate(built(box_builder()), 0.3f).exposure, 1);
  SceneBuilder daylight = box_builder();
  daylight.light_node(sun({1, 1, 1}, 100'000), shining_towards({0, -1, 0}));
  const scene::ExposureEstimate day = estimate(built(daylight), 0);
  EXPECT_FLOAT_EQ(day.illuminance_lux, 100'000);
  EXPECT_NEAR(day.exposure * 0.5f * 100'000 / kPi, 1.2f, 1e-3f) << "a grey surface is bright, not white";

  SceneBuilder lamp = box_builder();
  lamp.light_node(bulb(1e6f), at({0, 13, 0}));
  EXPECT_NEAR(estimate(built(lamp), 0).illuminance_lux, 1e4f, 1);

  scene::Material glowing = matte({0, 0, 0});
  glowing.emissive = glm::vec3(50);
  EXPECT_NEAR(estimate(built(box_builder(glowing)), 0.3f).exposure, 1.2f / 50.15f, 1e-4f);
  EXPECT_GT(estimate(built(box_builder()), 0.01f).exposure, 10);
  EXPECT_EQ(estimate(built(box_builder()), 0).exposure, 1) << "no light at all";
  EXPECT_EQ(estimate(scene::Scene(), 0).exposure, 1);
}

// A bulb lights the inside of its shade, which the camera does not see, and hardly its metal foot.
TEST(ExposureEstimate, ShadedLampDoesNotDarkenTheImage) {
  SceneBuilder builder;
  scene::Material bronze = matte({0.5f, 0.3f, 0.1f});
  bronze.metallic = 1;
  builder.mesh_node("foot", builder.box(builder.material(bronze), {0.3f, 0.7f, 0.3f}), at({0, 0.7f, 0}));
  builder.mesh_node("shade", builder.box(builder.material(matte({0.8f, 0.8f, 0.8f})), {0.5f, 0.3f, 0.5f}),
                    at({0, 1.9f, 0}));
  builder.light_node(bulb(180), at({0, 1.8f, 0}));
  const scene::ExposureEstimate lamp = estimate(built(builder), scene::kStudioMeanRadiance);
  EXPECT_EQ(lamp.exposure, 1) << lamp.illuminance_lux;
}

// A floor and two walls of 4 m around a lamp: all that the camera sees is lit.
TEST(ExposureEstimate, LampOfARoomCounts) {
  SceneBuilder builder;
  const uint32_t grey = builder.material(matte({0.5f, 0.5f, 0.5f}));
  builder.mesh_node("floor", builder.box(grey, {2, 0.01f, 2}), at({0, -0.01f, 0}));
  builder.mesh_node("back", builder.box(grey, {2, 2, 0.01f}), at({0, 2, -2.01f}));
  builder.mesh_node("left", builder.box(grey, {0.01f, 2, 2}), at({-2.01f, 2, 0}));
  builder.light_node(bulb(2000), at({0, 2, 0}));
  const scene::ExposureEstimate room = estimate(built(builder), scene::kStudioMeanRadiance);
  // A wall of side 4 m at 2 m receives a sixth of the lamp's 4 pi 2000 lumens.
  EXPECT_NEAR(room.illuminance_lux, 4 * kPi * 2000 / 6 / 16, 0.25f * 4 * kPi * 2000 / 6 / 16);
  EXPECT_LT(room.exposure, 0.1f);
}

TEST(Environment, MeanRadiance) {
  const auto constant = scene::make_environment(64, 32, [](const glm::vec3&) { return glm::vec3(0.5f); });
  EXPECT_NEAR(scene::mean_radiance(constant), 0.5f, 1e-3f);
  // The upper hemisphere is half of the sphere, although not half of the weighted rows' texels near the
  // poles.
  const auto sky = scene::make_environment(64, 32, [](const glm::vec3& d) { return glm::vec3(d.y > 0); });
  EXPECT_NEAR(scene::mean_radiance(sky), 0.5f, 1e-3f);
  EXPECT_NEAR(scene::mean_radiance(scene::studio_environment()), scene::kStudioMeanRadiance, 0.002f);
}

TEST(DefaultLook, GroundFollowsGradient) {
  const scene::Scene scene = built(box_builder());
  app::ViewDefaults defaults;
  app::CameraStart start = app::camera_start(defaults, scene, "", {});
  ASSERT_TRUE(start.ground);
  EXPECT_NEAR(start.ground->height_m, 1, 1e-4f);
  defaults.background.zenith.reset();
  EXPECT_FALSE(app::camera_start(defaults, scene, "", {}).ground) << "a plain colour stays plain";
  defaults.ground = app::GroundMode::height;
  defaults.ground_height_m = -2;
  EXPECT_EQ(app::camera_start(defaults, scene, "", {}).ground->height_m, -2);
  defaults = {};
  defaults.ground = app::GroundMode::off;
  EXPECT_FALSE(app::camera_start(defaults, scene, "", {}).ground);
  EXPECT_FALSE(app::camera_start({}, scene::Scene(), "", {}).ground) << "a scene without extent";
}

TEST(DefaultLook, ReasonsForAnEmptyImage) {
  SceneBuilder builder = box_builder();
  builder.camera_node("away", {0, 3, 10}, {0, 3, 20});
  builder.camera_node("aside", {0, 3, 10}, {10, 3, 4});
  builder.camera_node("far", {0, 3, 1e5f}, {0, 3, 0});
  builder.camera_node("good", {0, 3, 10}, {0, 3, 0});
  builder.camera_node("inside", {0, 3, 0}, {1, 3, 0});
  const scene::Scene scene = built(builder);
  const state::PoseState poses(scene);
  const auto reason = [&](const std::string& camera) {
    const app::CameraRig rig = *app::CameraRig::create(scene, {camera, false, {}, {}});
    return app::reason_for_empty_image(scene, nullptr, poses, rig.view(poses, 1.5f), 480).value_or("");
  };
  EXPECT_NE(reason("away").find("behind camera \"away\""), std::string::npos) << reason("away");
  EXPECT_NE(reason("aside").find("outside of the view of camera \"aside\""), std::string::npos);
  EXPECT_NE(reason("far").find("smaller than a pixel"), std::string::npos) << reason("far");
  EXPECT_NE(reason("inside").find("only backs of single-sided triangles"), std::string::npos)
      << reason("inside");
  EXPECT_EQ(reason("good"), "");
  EXPECT_EQ(reason("auto"), "");
  const scene::Scene nothing = built(SceneBuilder());
  const state::PoseState none(nothing);
  EXPECT_EQ(app::reason_for_empty_image(nothing, nullptr, none, passes::View(), 480),
            "the scene has no meshes");
}

// The catcher reaches beyond the shadows of the scene's lights, where it has hardly begun to fade.
TEST(DefaultLook, GroundReachesBeyondShadows) {
  const auto reach = [](const scene::Scene& scene) {
    const std::optional<scene::Ground> ground = app::camera_start({}, scene, "", {}).ground;
    float farthest_m = 0;
    for (const std::vector<glm::vec3>& of_light : passes::ground_shadows(
             scene, std::vector<glm::vec3>{scene.bounds_min, scene.bounds_max}, ground->height_m))
      for (const glm::vec3& shadow : of_light)
        farthest_m = std::max(farthest_m, glm::length(glm::vec2(shadow.x, shadow.z) - ground->center_world));
    return farthest_m / ground->radius_m;
  };
  SceneBuilder tall;
  tall.mesh_node("box", tall.box(tall.material(matte({0.5f, 0.5f, 0.5f})), {0.1f, 2, 0.1f}), at({0, 2, 0}));
  SceneBuilder low_sun = tall;
  low_sun.light_node(sun({1, 1, 1}, 2), shining_towards({-1, -0.36f, 0}));
  scene::Scene scene = built(tall);
  scene::add_key_light(scene);
  EXPECT_LT(reach(scene), 0.56f);
  EXPECT_LT(reach(built(low_sun)), 0.56f);
  EXPECT_GT(reach(built(low_sun)), 0.4f);
}

// The shadow of a tall box ends inside the image, and the box is not made smaller without need.
TEST(DefaultLook, GroundShadowsAreInTheImage) {
  const auto lowest_shadow = [](const scene::Scene& scene, bool has_ground, glm::vec3* eye) {
    app::ViewDefaults defaults;
    if (!has_ground) defaults.ground = app::GroundMode::off;
    const app::CameraRig rig = *app::CameraRig::create(scene, app::camera_start(defaults, scene, "auto", {}));
    const passes::View view = rig.view(state::PoseState(scene), 1.5f);
    *eye = view.eye_world;
    const std::vector<glm::vec3> corners{scene.bounds_min,
                                         scene.bounds_max,
                                         {scene.bounds_max.x, scene.bounds_max.y, scene.bounds_min.z},
                                         {scene.bounds_min.x, scene.bounds_max.y, scene.bounds_max.z}};
    float most = 0;
    for (const glm::vec3& shadow : passes::shadows_on_ground(
             corners, scene.bounds_min.y, glm::vec4(glm::vec3(scene.nodes.back().world_from_node[2]), 0))) {
      const glm::vec4 clip = view.clip_from_world * glm::vec4(shadow, 1);
      most = std::max({most, std::abs(clip.x / clip.w), std::abs(clip.y / clip.w)});
    }
    return most;
  };
  SceneBuilder wide, flat;
  wide.mesh_node("box", wide.box(wide.material(matte({0.5f, 0.5f, 0.5f})), {4, 1, 0.5f}), at({0, 1, 0}));
  flat.mesh_node("box", flat.box(flat.material(matte({0.5f, 0.5f, 0.5f})), {1, 0.05f, 1}), at({0, 1, 0}));
  scene::Scene scene = built(wide);
  scene::add_key_light(scene);
  glm::vec3 with, without;
  EXPECT_GT(lowest_shadow(scene, false, &without), 1);
  EXPECT_LT(lowest_shadow(scene, true, &with), 1);
  SceneBuilder low_sun = wide;
  low_sun.light_node(sun({1, 1, 1}, 2), shining_towards({-1, -0.03f, 0}));
  scene = built(low_sun);
  EXPECT_GT(lowest_shadow(scene, true, &with), 1) << "a shadow of 30 times the height";
  EXPECT_EQ(with, without);
  scene = built(flat);
  scene::add_key_light(scene);
  EXPECT_LT(lowest_shadow(scene, true, &with), 1);
  EXPECT_LT(lowest_shadow(scene, false, &without), 1);
  EXPECT_EQ(with, without);
}

// A lamp at twice the height of a robot, as many descriptions have it: its shadow is as long as the robot is
// tall. Another light whose shadow is too long for the image changes nothing.
TEST(DefaultLook, EachLightHasItsShadowInTheImage) {
  const auto shown = [](const scene::Scene& scene, const glm::vec4& light, glm::vec3* eye) {
    const app::CameraRig rig = *app::CameraRig::create(scene, app::camera_start({}, scene, "auto", {}));
    const passes::View view = rig.view(state::PoseState(scene), 4.0f / 3);
    *eye = view.eye_world;
    const std::vector<glm::vec3> top{{0.5f, 1, -0.1f}, {0.5f, 1, 0.1f}, {0.7f, 1, 0.1f}, {0.7f, 1, -0.1f}};
    float most = 0;
    for (const glm::vec3& shadow : passes::shadows_on_ground(top, scene.bounds_min.y, light)) {
      const glm::vec4 clip = view.clip_from_world * glm::vec4(shadow, 1);
      most = std::max({most, std::abs(clip.x / clip.w), std::abs(clip.y / clip.w)});
    }
    return most;
  };
  SceneBuilder robot;
  const uint32_t matter = robot.material(matte({0.5f, 0.5f, 0.5f}));
  robot.mesh_node("post", robot.box(matter, {0.1f, 0.5f, 0.1f}), at({0, 0.5f, 0}));
  robot.mesh_node("boom", robot.box(matter, {0.4f, 0.05f, 0.1f}), at({0.3f, 0.95f, 0}));
  SceneBuilder with_low_sun = robot;
  with_low_sun.light_node(sun({1, 1, 1}, 2), shining_towards({-1, -0.03f, 0}));
  scene::Light lamp;
  lamp.type = scene::LightType::point;
  lamp.intensity = 100;
  for (SceneBuilder* builder : {&robot, &with_low_sun}) builder->light_node(lamp, at({0, 2, 0}));
  glm::vec3 eye, eye_with_sun;
  EXPECT_LT(shown(built(robot), {0, 2, 0, 1}, &eye), 1);
  EXPECT_LT(shown(built(with_low_sun), {0, 2, 0, 1}, &eye_with_sun), 1);
  EXPECT_EQ(eye, eye_with_sun);
}

TEST(DefaultLook, CamerasByName) {
  SceneBuilder builder = box_builder();
  builder.camera_node("near", {0, 3, 3}, {0, 3, 0});
  const scene::Scene scene = built(builder);
  const state::PoseState poses(scene);
  const auto view = [&](const std::string& name, bool frame_all) {
    return app::CameraRig::create(scene, {name, frame_all, {}, {}})->view(poses, 1);
  };
  EXPECT_EQ(view("", false).eye_world, glm::vec3(0, 3, 3));
  EXPECT_EQ(view("near", false).eye_world, glm::vec3(0, 3, 3));
  EXPECT_GT(view("auto", false).eye_world.x, 1);
  const passes::View framed = view("near", true);
  EXPECT_NEAR(framed.look_world.z, -1, 1e-5f) << "the direction stays";
  EXPECT_GT(framed.eye_world.z, 3) << "and the whole box is in view";
  const Result<app::CameraRig> unknown = app::CameraRig::create(scene, {"nobody", false, {}, {}});
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("no such camera; there is \"near\"; or use --camera auto"),
            std::string::npos);
  const Result<app::CameraRig> mistyped = app::CameraRig::create(scene, {"naer", false, {}, {}});
  EXPECT_NE(mistyped.error().message.find("no such camera; did you mean \"near\"? Or use --camera auto"),
            std::string::npos);
  EXPECT_EQ(view("auto", false).camera, "auto");
}

// A camera that follows a recording frames its motion, and not the scene at rest.
TEST(CameraStart, FramedPointsReplaceTheSceneAtRest) {
  const scene::Scene scene = built(box_builder());
  const state::PoseState poses(scene);
  const auto view = [&](const std::vector<glm::vec3>& points) {
    auto rig = app::CameraRig::create(scene, {"auto", false, {}, {}});
    rig->set_framed_points(points);
    return rig->view(poses, 1);
  };
  const std::vector<glm::vec3> far{{-50, 0, 0}, {50, 10, 0}};
  const passes::View at_rest = view({}), moving = view(far);
  EXPECT_GT(glm::length(moving.eye_world), 4 * glm::length(at_rest.eye_world));
  for (const glm::vec3& point : far) {
    const glm::vec4 clip = moving.clip_from_world * glm::vec4(point, 1);
    EXPECT_LT(std::abs(clip.x), clip.w);
    EXPECT_LT(std::abs(clip.y), clip.w);
  }
}

// A scene that names its default view starts with it, unless a camera is asked for.
TEST(CameraStart, DefaultViewsPrecedeCameras) {
  SceneBuilder builder = box_builder();
  builder.camera_node("camera", {0, 3, 9}, {0, 3, 0});
  scene::Scene scene = builder.build();
  EXPECT_FALSE(app::CameraRig::create(scene)->is_free());
  scene.view_from = glm::normalize(glm::vec3(1, 0.45f, 0.75f));
  const auto rig = app::CameraRig::create(scene);
  ASSERT_TRUE(rig->is_free());
  const passes::View view = rig->view(state::PoseState(scene), 1.5f);
  EXPECT_LT(glm::distance(-view.look_world, scene.view_from), 1e-5f);
  EXPECT_FALSE(app::CameraRig::create(scene, {"camera", false, {}, std::nullopt})->is_free());
}

}  // namespace
}  // namespace fire3dv::test

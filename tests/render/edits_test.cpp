// Render test of scene edits: an edited scene equals a scene built that way, on both raster paths and with
// every shadow technique. A withdrawn edit restores the image byte for byte, and no GPU objects leak.
#include <gtest/gtest.h>

#include "renderer/scene/model/scene_edits.h"
#include "tests/render/support/bent_bar.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{160, 120};
const glm::vec4 kRed{0.7f, 0.05f, 0.05f, 1}, kGreen{0.05f, 0.5f, 0.1f, 1};

struct Way {
  const char* name;
  settings::RasterPath raster;
  settings::ShadowSettings shadows;
};
const Way kConfigurations[] = {
    {"hybrid",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::query}},
    {"forward", settings::RasterPath::forward, {settings::ShadowMethod::ray}},
    {"pipeline",
     settings::RasterPath::visibility,
     {settings::ShadowMethod::ray, true, settings::RayBackEnd::pipeline}},
    {"maps", settings::RasterPath::visibility, {settings::ShadowMethod::map}},
};

// Variant of the room below, applied when the scene is built.
struct Room {
  bool ball = true, table = true, glass = true, screen = true;
  std::optional<glm::vec4> twin_color, glass_color;
  scene::Light sun = test::sun({1, 0.9f, 0.8f}, 2);
  std::optional<scene::Light> lamp;
  float vertical_fov_rad = 0.7f;
};

scene::Material tinted(glm::vec4 color, scene::AlphaMode mode = scene::AlphaMode::opaque) {
  scene::Material material = matte(glm::vec3(color));
  material.base_color = color;
  material.alpha_mode = mode;
  material.clearcoat = mode == scene::AlphaMode::opaque ? 0.5f : 0;  // an extension that a copy must retain
  return material;
}

// A ground, a table with a cup on it, two balls of one mesh, a pane of glass, and a flat screen that casts a
// shadow. A removed object leaves an empty node, so that indices stay.
scene::Scene room(const Room& wanted) {
  SceneBuilder builder;
  const glm::vec4 clay(0.6f, 0.5f, 0.4f, 1), water(0.2f, 0.4f, 0.8f, 0.5f);
  const uint32_t ball = builder.sphere(builder.material(tinted(clay)), 0.5f, 24);
  const uint32_t twin =
      wanted.twin_color ? builder.sphere(builder.material(tinted(*wanted.twin_color)), 0.5f, 24) : ball;
  const uint32_t box = builder.box(builder.material(tinted({0.4f, 0.6f, 0.3f, 1})), {0.4f, 0.1f, 0.4f});
  const uint32_t cup = builder.box(builder.material(matte({0.9f, 0.9f, 0.2f})), {0.1f, 0.2f, 0.1f});
  const uint32_t pane = builder.quad(
      builder.material(tinted(wanted.glass_color.value_or(water), scene::AlphaMode::blend)), 0.4f);
  const uint32_t screen = builder.quad(builder.material(matte({0.8f, 0.8f, 0.8f})), 0.8f);
  const uint32_t ground = builder.quad(builder.material(matte({0.7f, 0.7f, 0.7f})), 20);
  const auto kept = [](bool is_kept, uint32_t mesh) { return is_kept ? mesh : scene::kNone; };

  builder.mesh_node("ground", ground, glm::mat4(1));
  builder.mesh_node("ball", kept(wanted.ball, ball), at({-1, 0.5f, 0}));
  builder.mesh_node("twin", twin, at({1.1f, 0.5f, 0}));
  const uint32_t table = builder.mesh_node("table", kept(wanted.table, box), at({0, 0.8f, -0.8f}));
  builder.mesh_node("cup", kept(wanted.table, cup), at({0, 0.3f, 0}), table);
  builder.mesh_node("glass", kept(wanted.glass, pane), at({0, 0.3f, 0.9f}));
  builder.mesh_node("screen", kept(wanted.screen, screen), at({0.5f, 1.8f, -0.4f}));
  builder.light_node(wanted.sun, shining_towards({-0.5f, -1, -0.4f}));
  builder.mesh_node("lamp", scene::kNone, shining_towards({0.6f, -1, -0.5f}, {-1.5f, 2, 1.5f}));
  builder.camera_node("camera", {0.5f, 2.2f, 4}, {0, 0.5f, 0}, wanted.vertical_fov_rad);
  scene::Scene scene = builder.build();
  if (wanted.lamp) {
    for (scene::Node& node : scene.nodes) {
      if (node.name == "lamp") node.light = static_cast<uint32_t>(scene.lights.size());
    }
    scene.lights.push_back(*wanted.lamp);
  }
  return scene;
}

uint32_t named(const scene::Scene& scene, const std::string& name) {
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].name == name) return n;
  }
  ADD_FAILURE() << "no node " << name;
  return 0;
}

settings::DrawSettings settings_of(const Way& way) {
  settings::DrawSettings settings;
  settings.raster = way.raster;
  settings.shadows = way.shadows;
  settings.post.fxaa = false;
  return settings;
}

// One scene in one renderer, drawn repeatedly between edits.
class Edited {
 public:
  Edited(const scene::Scene& scene, const Way& way)
      : scene_(scene), poses_(scene), bench_(scene, kExtent, settings_of(way)) {
    bench_.renderer().set_edits(edits_);
  }
  sinks::FrameImage draw(scene::NodeEdits edits) {
    edits_.set(scene_, std::move(edits));
    return bench_.draw(poses_, first_camera_view(scene_, poses_, kExtent));
  }

 private:
  const scene::Scene& scene_;
  state::PoseState poses_;
  scene::SceneEdits edits_;
  RenderBench bench_;
};

scene::NodeEdit hidden() {
  scene::NodeEdit edit;
  edit.hidden = true;
  return edit;
}
scene::NodeEdit colored(const glm::vec4& color) {
  scene::NodeEdit edit;
  edit.base_color = color;
  return edit;
}
scene::NodeEdit shining(const scene::Light& light) {
  scene::NodeEdit edit;
  edit.light = light;
  return edit;
}

class Edits : public ValidationIsSilent, public ::testing::WithParamInterface<Way> {
 protected:
  // One renderer for all scenes: pipeline creation dominates the time of a new renderer.
  sinks::FrameImage made_so(const Room& wanted) {
    const scene::Scene scene = room(wanted);
    if (!bench_) bench_.emplace(scene, kExtent, settings_of(GetParam()));
    bench_->renderer().set_scene(scene);
    const state::PoseState poses(scene);
    return bench_->draw(poses, first_camera_view(scene, poses, kExtent));
  }
  static std::string file(const char* what) { return std::string("edits_") + GetParam().name + "_" + what; }

 private:
  std::optional<RenderBench> bench_;
};

TEST_P(Edits, HiddenNodeReappears) {
  const scene::Scene scene = room({});
  Edited edited(scene, GetParam());
  const sinks::FrameImage before = edited.draw({});
  const scene::NodeEdits edits{{named(scene, "ball"), hidden()},
                               {named(scene, "table"), hidden()},
                               {named(scene, "screen"), hidden()}};
  Room left;
  left.ball = left.table = left.screen = false;
  const sinks::FrameImage without = edited.draw(edits);
  EXPECT_TRUE(matches_image(without, made_so(left), file("hidden"), Tolerance::colour()));
  EXPECT_FALSE(matches_image(without, before, file("hidden_at_all"), Tolerance::colour()));
  left.glass = false;
  EXPECT_TRUE(matches_image(edited.draw({{named(scene, "ball"), hidden()},
                                         {named(scene, "glass"), hidden()},
                                         {named(scene, "table"), hidden()},
                                         {named(scene, "screen"), hidden()}}),
                            made_so(left), file("hidden_glass"), Tolerance::colour()));
  EXPECT_TRUE(matches_image(edited.draw({}), before, file("shown_again"), Tolerance::exact()));
}

TEST_P(Edits, NodeColourIsRestored) {
  const scene::Scene scene = room({});
  Edited edited(scene, GetParam());
  const sinks::FrameImage before = edited.draw({});
  const uint32_t twin = named(scene, "twin"), glass = named(scene, "glass"), ball = named(scene, "ball");
  const glm::vec4 smoke(0.6f, 0.1f, 0.1f, 0.8f);
  Room other;
  other.twin_color = kRed;
  EXPECT_TRUE(
      matches_image(edited.draw({{twin, colored(kRed)}}), made_so(other), file("red"), Tolerance::colour()));
  other.twin_color = kGreen;  // the same node again, then one before and one behind it
  EXPECT_TRUE(matches_image(edited.draw({{twin, colored(kGreen)}}), made_so(other), file("green"),
                            Tolerance::colour()));
  other.glass_color = smoke;
  EXPECT_TRUE(matches_image(
      edited.draw({{ball, colored({0.6f, 0.5f, 0.4f, 1})}, {twin, colored(kGreen)}, {glass, colored(smoke)}}),
      made_so(other), file("smoke"), Tolerance::colour()));
  other.twin_color = {};
  EXPECT_TRUE(matches_image(edited.draw({{glass, colored(smoke)}}), made_so(other), file("smoke_alone"),
                            Tolerance::colour()));
  EXPECT_TRUE(matches_image(edited.draw({}), before, file("own_colour_again"), Tolerance::exact()));
}

TEST_P(Edits, LightsChangeComeAndGo) {
  const scene::Scene scene = room({});
  Edited edited(scene, GetParam());
  const sinks::FrameImage before = edited.draw({});
  const uint32_t light = named(scene, "light_1"), lamp_node = named(scene, "lamp");
  Room other;
  other.sun = sun({0.4f, 0.5f, 1}, 1);
  EXPECT_TRUE(matches_image(edited.draw({{light, shining(other.sun)}}), made_so(other), file("dusk"),
                            Tolerance::colour()));
  scene::Light lamp;
  lamp.type = scene::LightType::spot;
  lamp.color = {1, 0.8f, 0.5f};
  lamp.intensity = 15;
  lamp.outer_cone_rad = 0.5f;
  other.lamp = lamp;
  EXPECT_TRUE(matches_image(edited.draw({{light, shining(other.sun)}, {lamp_node, shining(lamp)}}),
                            made_so(other), file("lamp"), Tolerance::colour()));
  lamp.type = scene::LightType::point;  // six shadow map views instead of one
  other.lamp = lamp;
  other.sun = Room{}.sun;
  EXPECT_TRUE(matches_image(edited.draw({{lamp_node, shining(lamp)}}), made_so(other), file("bulb"),
                            Tolerance::colour()));
  EXPECT_TRUE(matches_image(edited.draw({}), before, file("own_lights_again"), Tolerance::exact()));
}

TEST_P(Edits, LightWithoutShadowsShinesThroughEverything) {
  const scene::Scene scene = room({});
  Edited edited(scene, GetParam());
  scene::Light light = Room{}.sun;
  light.casts_shadow = false;
  settings::DrawSettings off = settings_of(GetParam());
  off.shadows.method = settings::ShadowMethod::off;
  RenderBench without(scene, kExtent, off);
  EXPECT_TRUE(matches_image(edited.draw({{named(scene, "light_1"), shining(light)}}), without.draw_at_rest(),
                            file("no_shadow"), Tolerance::colour()));
}

TEST_P(Edits, DeformedNodesAreEditedAsOthers) {
  const BarPose pose{at({0.2f, 0, 0}), at({0, 1, 0.1f}), 0.5f};
  const scene::Scene skinned = skinned_bar(pose), computed = computed_bar(pose);
  const auto edits_of = [](const scene::Scene& scene) {
    return scene::NodeEdits{{named(scene, "bar"), colored(kRed)}, {named(scene, "beside"), hidden()}};
  };
  Edited moves(skinned, GetParam()), stays(computed, GetParam());
  const sinks::FrameImage before = moves.draw({});
  EXPECT_TRUE(matches_image(moves.draw(edits_of(skinned)), stays.draw(edits_of(computed)), file("deformed"),
                            Tolerance::colour()));
  EXPECT_TRUE(matches_image(moves.draw({{named(skinned, "bar"), hidden()}}),
                            stays.draw({{named(computed, "bar"), hidden()}}), file("deformed_hidden"),
                            Tolerance::colour()));
  EXPECT_TRUE(matches_image(moves.draw({}), before, file("deformed_again"), Tolerance::exact()));
}

INSTANTIATE_TEST_SUITE_P(Ways, Edits, ::testing::ValuesIn(kConfigurations),
                         [](const auto& way) { return std::string(way.param.name); });

class EditsOnce : public ValidationIsSilent {};

TEST_F(EditsOnce, AsItWasLookedAt) {
  const scene::Scene scene = room({});
  Edited edited(scene, kConfigurations[0]);
  scene::Light lamp;
  lamp.type = scene::LightType::spot;
  lamp.color = {1, 0.8f, 0.5f};
  lamp.intensity = 15;
  lamp.outer_cone_rad = 0.5f;
  EXPECT_TRUE(matches_golden(edited.draw({{named(scene, "ball"), hidden()},
                                          {named(scene, "twin"), colored(kRed)},
                                          {named(scene, "lamp"), shining(lamp)}}),
                             "edits", Tolerance::colour()));
}

// Every kind of edit, repeatedly: replaced objects are released, and frames without edits write nothing.
TEST_F(EditsOnce, NothingIsLeftBehind) {
  const scene::Scene scene = room({});
  Edited edited(scene, kConfigurations[0]);
  scene::Light lamp;
  lamp.intensity = 5;
  const scene::NodeEdits all{{named(scene, "ball"), hidden()},
                             {named(scene, "twin"), colored(kRed)},
                             {named(scene, "lamp"), shining(lamp)}};
  const auto settled = [&] {
    for (int frame = 0; frame < 3; ++frame) (void)edited.draw({});
    device().retire_all_now();
    return device().live_objects();
  };
  (void)edited.draw(all);
  const gpu::LiveObjects before = settled();
  const uint64_t bytes_before = device().allocated_bytes();
  for (int i = 0; i < 5; ++i) (void)edited.draw(all);
  EXPECT_EQ(settled(), before);
  EXPECT_EQ(device().allocated_bytes(), bytes_before);
}

TEST_F(EditsOnce, NewSceneGetsEdits) {
  const scene::Scene scene = room({});
  RenderBench bench(scene, kExtent, settings_of(kConfigurations[0]));
  scene::SceneEdits edits;
  edits.set(scene, {{named(scene, "ball"), hidden()}, {named(scene, "twin"), colored(kRed)}});
  bench.renderer().set_edits(edits);
  const sinks::FrameImage before = bench.draw_at_rest();
  bench.renderer().set_scene(scene);
  EXPECT_TRUE(matches_image(bench.draw_at_rest(), before, "edits_set_anew", Tolerance::exact()));
}

}  // namespace
}  // namespace fire3dv::test

// Test of the gizmo by scripted mouse moves: the grabbed point stays below the cursor within half a pixel, by
// an oracle that projects the moved node with the camera's matrix; driven nodes refuse.
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "renderer/gui/gizmo.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using app::GizmoTool;
using gui::GizmoHandle;

constexpr uint32_t kFree = 3;    // the sun's node, below nothing
constexpr uint32_t kDriven = 1;  // "arm"
constexpr float kPixel = 0.5f;

// A camera that sees all three axes of the origin, from a distance of about 8 m.
passes::View look(float aspect, bool orthographic = false) {
  scene::Camera camera;
  camera.vertical_fov_rad = 0.7f;
  camera.orthographic = orthographic;
  camera.half_extent_m = {4 * aspect, 4};
  return passes::make_view(camera, passes::look_at_pose({5, 4, 6}, {0, 0.5f, 0}), aspect);
}

class Gizmos : public ::testing::Test {
 protected:
  Gizmos() {
    world_.image_view = [this](float aspect) { return look(aspect, is_orthographic_); };
    world_.view_state.selected = kFree;
    state::NodeTransform placed;
    placed.translation = {0.5f, 0.25f, -0.5f};
    placed.rotation = glm::angleAxis(0.6f, glm::normalize(glm::vec3(1, 2, 3)));
    placed.scale = {1, 2, 0.5f};
    world_.view_state.edits.transforms[kFree] = placed;
    world_.settle();
  }

  void open_edit_panel() {
    world_.gui.note_controls(true);
    world_.settle();
    for (const gui::Control& control : world_.gui.controls()) {
      if (control.kind != gui::Control::Kind::header || control.name != "Edit") continue;
      world_.frame({gui::MouseMoved{(control.rect.low + control.rect.high) * 0.5f}});
      world_.frame({gui::MouseButton{gui::Button::left, true}});
      world_.frame({gui::MouseButton{gui::Button::left, false}});
      break;
    }
    world_.settle();
  }
  glm::mat4 node() const { return world_.poses.world_from_node(kFree); }
  glm::vec2 pixel(const glm::vec3& at) const {
    const gui::Rect image = world_.gui.image_rect();
    const glm::vec2 size = image.high - image.low;
    const glm::vec4 clip = look(size.x / size.y, is_orthographic_).clip_from_world * glm::vec4(at, 1);
    return image.low + (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size;
  }
  // A gizmo like the one in the image, to find its handles.
  gui::Gizmo gizmo() const {
    const gui::Rect image = world_.gui.image_rect();
    const glm::vec2 size = image.high - image.low;
    gui::Gizmo placed;
    placed.place({look(size.x / size.y, is_orthographic_), image.low, size}, node(), world_.view_state.tool,
                 world_.view_state.tool_is_local, world_.scale);
    return placed;
  }
  glm::vec2 handle(GizmoHandle::Kind kind, int axis, float where = 0.7f) const {
    const gui::Gizmo placed = gizmo();
    for (const GizmoHandle& each : placed.handles()) {
      if (each.kind != kind || each.axis != axis) continue;
      if (kind == GizmoHandle::Kind::axis) return glm::mix(each.outline[0], each.outline[1], where);
      if (kind == GizmoHandle::Kind::plane) return (each.outline[0] + each.outline[2]) * 0.5f;
      return each.outline[static_cast<size_t>(where * static_cast<float>(each.outline.size() - 1))];
    }
    ADD_FAILURE() << "no handle of axis " << axis;
    return {};
  }
  void press(const glm::vec2& at) {
    world_.frame({gui::MouseMoved{at}});
    EXPECT_TRUE(world_.gui.wants_mouse()) << "nothing is below the cursor";
    world_.frame({gui::MouseButton{gui::Button::left, true}});
  }
  void move(const glm::vec2& at) {
    world_.frame({gui::MouseMoved{at}});
    EXPECT_TRUE(world_.gui.is_interacting());
  }
  void release() {
    world_.frame({gui::MouseButton{gui::Button::left, false}});
    world_.frame();
    EXPECT_FALSE(world_.gui.is_interacting());
  }

  bool is_orthographic_ = false;
  GuiWorld world_;
};

// Along an axis the cursor stays on the axis's line, at the distance at which it grabbed it.
TEST_F(Gizmos, AxisMovesNodeBelowCursor) {
  for (const bool orthographic : {false, true}) {
    is_orthographic_ = orthographic;
    for (const bool local : {false, true}) {
      for (int axis = 0; axis < 3; ++axis) {
        world_.view_state.tool = GizmoTool::move;
        world_.view_state.tool_is_local = local;
        world_.settle();
        const glm::mat4 before = node();
        glm::vec3 direction(0);
        direction[axis] = 1;
        if (local) direction = glm::normalize(glm::vec3(before[axis]));
        const glm::vec2 from = handle(GizmoHandle::Kind::axis, axis);
        press(from);
        for (const float way : {0.1f, 0.4f, -0.3f}) {
          // The cursor goes where the moved handle will be seen: the world point that was grabbed, moved.
          const glm::vec3 origin(before[3]);
          float low = 0, high = 4;  // the grabbed distance on the axis, by bisection
          const float wanted = glm::length(from - pixel(origin));
          for (int i = 0; i < 60; ++i) {
            const float middle = (low + high) / 2;
            (glm::length(pixel(origin + direction * middle) - pixel(origin)) < wanted ? low : high) = middle;
          }
          const glm::vec2 to = pixel(origin + direction * (low + way));
          move(to);
          const glm::vec2 seen = pixel(glm::vec3(node()[3]) + direction * low);
          EXPECT_LT(glm::length(seen - to), kPixel) << "axis " << axis << (local ? ", local" : "");
          EXPECT_LT(glm::length(glm::vec3(node()[3]) - origin - direction * way), 0.01f);
        }
        release();
        for (int column = 0; column < 3; ++column)
          EXPECT_LT(glm::length(node()[column] - before[column]), 1e-5f) << "it has turned";
      }
    }
  }
}

TEST_F(Gizmos, PlaneAndCentreFollowCursor) {
  for (int axis = 0; axis < 4; ++axis) {
    world_.view_state.tool = GizmoTool::move;
    world_.settle();
    const glm::vec3 before(node()[3]);
    const auto kind = axis < 3 ? GizmoHandle::Kind::plane : GizmoHandle::Kind::centre;
    const glm::vec2 from = handle(kind, axis, 0);
    const gui::Rect image = world_.gui.image_rect();
    const glm::vec2 size = image.high - image.low;
    const gui::GizmoView view{look(size.x / size.y), image.low, size};
    press(from);
    for (const glm::vec2 way : {glm::vec2(40, 10), glm::vec2(-25, 60)}) {
      move(from + way);
      const glm::vec3 moved(node()[3]);
      // The point of the plane that was grabbed.
      const glm::vec3 normal = axis < 3 ? glm::vec3(axis == 0, axis == 1, axis == 2) : view.view.look_world;
      const gui::GizmoView::Ray ray = view.ray_through(from);
      const glm::vec3 grabbed = ray.origin + ray.direction * (glm::dot(normal, before - ray.origin) /
                                                              glm::dot(normal, ray.direction));
      EXPECT_LT(glm::length(pixel(grabbed + moved - before) - from - way), kPixel) << "axis " << axis;
      EXPECT_LT(std::abs(glm::dot(normal, moved - before)), 1e-4f);
    }
    release();
  }
}

TEST_F(Gizmos, RingTurnsNodeWithCursor) {
  for (const bool local : {false, true}) {
    for (int axis = 0; axis < 3; ++axis) {
      world_.view_state.tool = GizmoTool::rotate;
      world_.view_state.tool_is_local = local;
      world_.settle();
      const glm::mat4 before = node();
      glm::vec3 normal(0);
      normal[axis] = 1;
      if (local) normal = glm::normalize(glm::vec3(before[axis]));
      const glm::vec2 from = handle(GizmoHandle::Kind::ring, axis, 0.5f);
      const gui::Rect image = world_.gui.image_rect();
      const glm::vec2 size = image.high - image.low;
      const gui::GizmoView::Ray ray =
          gui::GizmoView{look(size.x / size.y), image.low, size}.ray_through(from);
      const glm::vec3 origin(before[3]);
      const glm::vec3 arm =
          ray.origin +
          ray.direction * (glm::dot(normal, origin - ray.origin) / glm::dot(normal, ray.direction)) - origin;
      press(from);
      float last = 0;
      for (const float angle : {0.05f, 0.3f, 0.6f, -0.4f}) {
        const glm::mat4 turn = glm::rotate(glm::mat4(1), angle, normal);
        move(pixel(origin + glm::vec3(turn * glm::vec4(arm, 0))));
        // What the node's frame says of the turn: the grabbed point, carried by the node.
        const glm::vec3 in_node = glm::inverse(glm::mat3(before)) * arm;
        const glm::vec2 carried = pixel(origin + glm::mat3(node()) * in_node);
        EXPECT_LT(glm::length(carried - pixel(origin + glm::vec3(turn * glm::vec4(arm, 0)))), kPixel)
            << "axis " << axis << " at " << angle;
        last = angle;
      }
      release();
      EXPECT_LT(glm::length(glm::vec3(node()[3]) - origin), 1e-5f);
      EXPECT_NE(last, 0);
    }
  }
}

TEST_F(Gizmos, HandlesScaleAxisOrAll) {
  for (int axis = 0; axis < 3; ++axis) {
    world_.view_state.tool = GizmoTool::scale;
    world_.settle();
    const glm::mat4 before = node();
    const glm::vec2 from = handle(GizmoHandle::Kind::axis, axis, 0.5f);
    const glm::vec3 origin(before[3]), direction = glm::normalize(glm::vec3(before[axis]));
    float low = 0, high = 4;
    const float wanted = glm::length(from - pixel(origin));
    for (int i = 0; i < 60; ++i) {
      const float middle = (low + high) / 2;
      (glm::length(pixel(origin + direction * middle) - pixel(origin)) < wanted ? low : high) = middle;
    }
    press(from);
    for (const float factor : {1.2f, 0.6f}) {
      const glm::vec2 to = pixel(origin + direction * (low * factor));
      move(to);
      // The grabbed point, carried by the node, is below the cursor.
      const glm::vec4 in_node = glm::inverse(before) * glm::vec4(origin + direction * low, 1);
      EXPECT_LT(glm::length(pixel(glm::vec3(node() * in_node)) - to), kPixel) << "axis " << axis;
      for (int other = 0; other < 3; ++other) {
        if (other == axis) continue;
        EXPECT_LT(glm::length(node()[other] - before[other]), 1e-5f);
      }
    }
    release();
  }
  const glm::mat4 before = node();
  const glm::vec2 from = handle(GizmoHandle::Kind::centre, 3, 0);
  press(from);
  move(from + glm::vec2(84, 0));  // the length of an axis doubles it
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(glm::length(node()[axis] - 2.0f * before[axis]), 1e-4f);
  release();
}

TEST_F(Gizmos, ControlSnaps) {
  world_.view_state.tool = GizmoTool::rotate;
  world_.settle();
  const glm::mat4 before = node();
  const glm::vec2 from = handle(GizmoHandle::Kind::ring, 1, 0.5f);
  gui::Input input;
  const auto frame = [&](gui::Event event) {
    input.display_px = world_.display_px;
    input.held.ctrl = true;
    input.events = {event};
    input.delta_s = 0.016f;
    gui::Shown shown{world_.scene, world_.poses, nullptr, 1,
                     &world_.timeline};  // the panels stay as they are
    shown.robot = &world_.robot;
    shown.view = world_.image_view;
    world_.gui.frame(input, world_.facts, shown, world_.view_state);
    state::RestPose rest = state::rest_pose(world_.scene);
    state::apply_transforms(world_.view_state.edits.transforms, world_.scene, rest);
    world_.poses.set_rest(rest);
  };
  frame(gui::MouseMoved{from});
  frame(gui::MouseButton{gui::Button::left, true});
  std::set<int> steps;
  for (int i = 1; i <= 30; ++i) {
    frame(gui::MouseMoved{from + glm::vec2(-4 * i, 0)});
    const glm::mat3 turn = glm::mat3(node()) * glm::inverse(glm::mat3(before));
    const float angle = glm::degrees(std::atan2(turn[2][0], turn[0][0]));
    EXPECT_NEAR(std::remainder(angle, 15.0f), 0, 0.01f);
    steps.insert(static_cast<int>(std::lround(angle / 15)));
  }
  EXPECT_GT(steps.size(), 2u);
  frame(gui::MouseButton{gui::Button::left, false});
}

TEST_F(Gizmos, DrivenNodeHasNoHandles) {
  world_.view_state.selected = kDriven;
  world_.view_state.tool = GizmoTool::move;
  open_edit_panel();
  const gui::Rect image = world_.gui.image_rect();
  const state::NodeTransforms before = world_.view_state.edits.transforms;
  for (float y = image.low.y + 2; y < image.high.y; y += 9) {
    for (float x = image.low.x + 2; x < image.high.x; x += 9) {
      world_.frame({gui::MouseMoved{{x, y}}});
      ASSERT_FALSE(world_.gui.wants_mouse()) << x << ", " << y;
    }
  }
  for (const gui::Control& control : world_.gui.controls())
    EXPECT_NE(control.kind, gui::Control::Kind::number);
  EXPECT_EQ(world_.view_state.edits.transforms, before);
  // The same node rests when the stream has left.
  world_.poses.remove_stream(0);
  world_.settle();
  size_t fields = 0;
  for (const gui::Control& control : world_.gui.controls())
    fields += control.kind == gui::Control::Kind::number ? 1 : 0;
  EXPECT_EQ(fields, 9u);
}

TEST_F(Gizmos, NumbersMoveTurnAndScale) {
  world_.display_px = {1600, 1400};
  open_edit_panel();
  std::vector<gui::Control> fields;
  for (const gui::Control& control : world_.gui.controls())
    if (control.kind == gui::Control::Kind::number) fields.push_back(control);
  ASSERT_EQ(fields.size(), 9u);
  for (const gui::Control& field : fields) {
    const glm::mat4 before = node();
    const glm::vec2 at = (field.rect.low + field.rect.high) * 0.5f;
    world_.frame({gui::MouseMoved{at}});
    world_.frame({gui::MouseButton{gui::Button::left, true}});
    world_.frame({gui::MouseMoved{at + glm::vec2(30, 0)}});
    world_.frame();
    release();
    EXPECT_NE(node(), before) << field.name;
    EXPECT_EQ(field.name.starts_with("Position"), glm::mat3(node()) == glm::mat3(before)) << field.name;
    EXPECT_TRUE(state::is_valid(world_.view_state.edits.transforms.at(kFree)));
  }
}

TEST_F(Gizmos, WithoutToolMouseIsCameras) {
  world_.view_state.tool = GizmoTool::none;
  world_.settle();
  world_.frame({gui::MouseMoved{pixel(glm::vec3(node()[3]))}});
  EXPECT_FALSE(world_.gui.wants_mouse());
  // A drag that began beside the handles stays the camera's when it crosses them.
  world_.view_state.tool = GizmoTool::move;
  world_.settle();
  const glm::vec2 axis = handle(GizmoHandle::Kind::axis, 0);
  const state::NodeTransforms before = world_.view_state.edits.transforms;
  world_.frame({gui::MouseMoved{axis + glm::vec2(0, 120)}});
  world_.frame({gui::MouseButton{gui::Button::left, true}});
  world_.frame({gui::MouseMoved{axis}});
  EXPECT_FALSE(world_.gui.wants_mouse());
  world_.frame({gui::MouseButton{gui::Button::left, false}});
  EXPECT_EQ(world_.view_state.edits.transforms, before);
}

}  // namespace
}  // namespace fire3dv::test

// Dragging of a stream's body in the window: from a picked point and cursor positions to events of the stream
// (wire::InputEvent). The simulator has the spring; this class knows its two ends.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/view/view.h"
#include "renderer/state/pose_state.h"
#include "renderer/streams/input_router.h"

namespace fire3dv::app {

class BodyDrag {
 public:
  // Borrows both.
  BodyDrag(const state::PoseState& poses, InputRouter& router) : poses_(poses), router_(router) {}
  ~BodyDrag() { router_.release(kWindow); }
  BodyDrag(const BodyDrag&) = delete;
  BodyDrag& operator=(const BodyDrag&) = delete;

  // Whether a stream takes drags of its bodies.
  bool is_possible() const;
  // The button is held from now on; the pick of what is under it may come later.
  void press() { is_pressed_ = true; }
  bool is_pressed() const { return is_pressed_; }
  // Grabs the body of a picked point, if the button is still held and its stream takes drags. Else nothing is
  // held; returns why, for the user.
  std::optional<std::string> grab(const passes::Picked& picked);
  // Moves the target under the cursor (NDC, y down), in the plane of the grabbed point that faces the camera.
  void move(glm::vec2 cursor_ndc, const passes::View& view);
  void release();

  // Both ends of the spring in the world, as shown: the grabbed point and the target.
  std::optional<std::array<glm::vec3, 2>> ends() const;

 private:
  static constexpr InputViewer kWindow = 0;
  struct Held {
    uint64_t epoch = 0;
    std::string input;
    uint32_t node = 0;  // of the stream
    glm::dvec3 point_body{0}, target_world{0};
  };
  const state::Stream* stream_of_held() const;
  bool act(wire::InputAction action) const;

  const state::PoseState& poses_;
  InputRouter& router_;
  bool is_pressed_ = false;
  std::optional<Held> held_;
};

}  // namespace fire3dv::app

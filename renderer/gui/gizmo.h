// Manipulator (gizmo) of a node in the image: handles that translate, rotate and scale it, their hit test,
// and the world transform that a drag means. Geometry alone, on the CPU: no ImGui, no scene, no streams.
// Pixels are those of the window; a dragged point stays below the cursor.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "renderer/editing/view_state.h"
#include "renderer/passes/view/view.h"

namespace fire3dv::gui {

// Image of a camera in the window.
struct GizmoView {
  passes::View view;
  glm::vec2 low_px{0}, size_px{1};  // of the image

  // nullopt: behind the camera.
  std::optional<glm::vec2> pixel_of(const glm::vec3& world) const;
  // Pixels that a point moves for one metre along the direction.
  glm::vec2 pixels_per_metre(const glm::vec3& world, const glm::vec3& direction) const;
  struct Ray {
    glm::vec3 origin, direction;  // unit
  };
  Ray ray_through(const glm::vec2& px) const;
  glm::vec3 right_world() const;
  // Unit, from the eye to the point.
  glm::vec3 look_at(const glm::vec3& world) const;
};

struct GizmoHandle {
  enum class Kind : uint8_t { axis, plane, ring, centre };
  Kind kind = Kind::axis;
  int axis = 0;  // 0 to 2: x, y, z; normal of a plane; 3: the view's axis
  // Drawn outline in pixels: an axis is two points, a plane a quad, a ring a chain of its visible part.
  std::vector<glm::vec2> outline;
};

class Gizmo {
 public:
  // Steps of a snapped drag.
  static constexpr float kSnapRad = 0.26179939f;  // 15 degrees
  static constexpr float kSnapScale = 0.1f;

  // Places the handles. points: pixels per point of the display. No handles if the node is behind the camera.
  // Call once per frame; a drag goes on with the same handle.
  void place(const GizmoView& view, const glm::mat4& world_from_node, app::GizmoTool tool, bool is_local,
             float points);
  const std::vector<GizmoHandle>& handles() const { return handles_; }
  // Index of the handle below the cursor.
  std::optional<size_t> hit(const glm::vec2& cursor_px) const;

  // A drag of a handle. drag() returns the node's transform; world_from_node was that of the last place().
  void begin(size_t handle, const glm::vec2& cursor_px);
  glm::mat4 drag(const glm::vec2& cursor_px, bool snaps);
  void end() { dragged_.reset(); }
  bool is_dragging() const { return dragged_.has_value(); }
  // Handle of the drag, by kind and axis.
  bool is_dragged(const GizmoHandle& handle) const;
  float value() const { return value_; }  // of the drag: metres, radians or a factor
  float snap_m() const;                   // step of a snapped translation: a power of ten metres

 private:
  struct Drag {
    app::GizmoTool tool{};
    GizmoHandle::Kind kind{};
    int axis = 0;
    glm::mat4 world_from_node{1};
    glm::vec3 axis_world{1, 0, 0};
    glm::vec3 normal_world{0, 0, 1};  // of the plane of a translation
    glm::vec3 grabbed_world{0};       // in the plane
    float grabbed = 0;                // along the axis
    glm::vec2 grabbed_px{0};
    float turned_rad = 0;  // so far, over several turns
    float last_rad = 0;
  };
  void add_axes(float points);
  void add_planes(float points);
  void add_rings(float points);
  bool is_seen(int axis) const;
  float along_axis(const glm::vec3& axis, const glm::vec2& px) const;
  std::optional<glm::vec3> on_plane(const glm::vec3& normal, const glm::vec2& px) const;
  float angle_at(const Drag& drag, const glm::vec2& px) const;
  glm::mat4 translated(const glm::vec2& px, bool snaps);
  glm::mat4 rotated(const glm::vec2& px, bool snaps);
  glm::mat4 scaled(const glm::vec2& px, bool snaps);

  GizmoView view_;
  app::GizmoTool tool_ = app::GizmoTool::none;
  glm::mat4 world_from_node_{1};
  glm::vec3 origin_{0};
  std::array<glm::vec3, 3> axes_{};  // unit, of the chosen frame
  float length_m_ = 1;               // of an axis, seen from the side
  float points_ = 1;
  glm::vec2 centre_px_{0};
  std::vector<GizmoHandle> handles_;
  std::optional<Drag> dragged_;
  float value_ = 0;
};

}  // namespace fire3dv::gui

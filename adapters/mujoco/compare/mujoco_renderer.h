// MuJoCo's own offscreen renderer: what one of its cameras sees, as colours, labels and depth.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>
#include <vector>

#include "adapters/mujoco/compare/labels.h"
#include "protocol/error.h"
#include "tools/convert/mjcf_load.h"

namespace fire3dv::mujoco {

struct MujocoView {
  std::string camera = "free camera";  // by name, or where MuJoCo's viewer starts
  uint32_t width = 640, height = 480;
  int samples = 0;          // a pixel; labels are always of one
  int shadow_texels = 0;    // sides of the shadows' maps; 0: no shadows
  bool fine = false;        // round shapes of many more triangles than MuJoCo draws by itself
  bool reflections = true;  // of floors, as MuJoCo draws them by itself
};

class MujocoRenderer {
 public:
  // An OpenGL context must be current for as long as this lives.
  static Result<MujocoRenderer> open(const mjModel& model, const MujocoView& view);
  ~MujocoRenderer();
  MujocoRenderer(MujocoRenderer&& other) noexcept;
  MujocoRenderer& operator=(MujocoRenderer&&) = delete;

  // Both draw and read back. What a user of MuJoCo does for colour and depth, and for labels.
  Result<void> draw_color_and_depth(const mjData& data);
  Result<void> draw_labels(const mjData& data);

  // Of what was drawn last, as MuJoCo leaves it: 3 bytes a pixel, rows from the bottom.
  const std::vector<uint8_t>& color() const { return color_; }
  // Rows from the top.
  std::vector<uint8_t> upright_color() const;
  std::vector<uint32_t> labels() const;   // after draw_labels
  std::vector<float> depths_m() const;    // after draw_color_and_depth
  float far_m() const { return far_m_; }  // what is farther is not drawn

 private:
  MujocoRenderer(const MujocoView& view, convert::MjcfModel model);
  Result<void> draw(const mjData& data, bool labels);

  MujocoView view_;
  convert::MjcfModel model_;  // a copy whose looks are those of the view
  bool open_ = false;
  float near_m_, far_m_;
  mjvCamera camera_{};
  mjvOption option_{};
  mjvScene scene_{};
  mjrContext context_{};
  std::vector<uint8_t> color_;
  std::vector<float> depth_;
};

}  // namespace fire3dv::mujoco

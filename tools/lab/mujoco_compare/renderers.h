// Renderers under comparison, for one camera of a model: MuJoCo's offscreen renderer (colours, labels and
// depth; needs a current OpenGL context on the calling thread), and a lockstep client of FIRE-3DV. One
// thread.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>
#include <vector>

#include "adapters/mujoco/compiled/load.h"
#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"
#include "base/error.h"
#include "tools/lab/mujoco_compare/labels.h"

namespace fire3dv::mujoco {

class EglContext {
 public:
  // Uses Mesa's surfaceless platform: a hardware driver where Mesa has one, else its software renderer.
  static Result<EglContext> open();
  ~EglContext();
  EglContext(EglContext&& other) noexcept;
  EglContext& operator=(EglContext&&) = delete;

  // Returns GL_RENDERER.
  std::string renderer() const;

 private:
  EglContext(void* display, void* context) : display_(display), context_(context) {}
  void* display_;
  void* context_;
};

struct MujocoView {
  std::string camera = "free camera";  // by name; default: the start view of MuJoCo's viewer
  uint32_t width = 640, height = 480;
  int samples = 0;          // MSAA samples per pixel; labels always use one
  int shadow_texels = 0;    // resolution of shadow maps; 0: no shadows
  bool fine = false;        // tessellates round shapes far more finely than MuJoCo's default
  bool reflections = true;  // floor reflections, MuJoCo's default
};

class MujocoRenderer {
 public:
  // The OpenGL context must stay current during the object's lifetime.
  static Result<MujocoRenderer> open(const mjModel& model, const MujocoView& view);
  ~MujocoRenderer();
  MujocoRenderer(MujocoRenderer&& other) noexcept;
  MujocoRenderer& operator=(MujocoRenderer&&) = delete;

  // Each call draws and reads back, as a MuJoCo user does for colour and depth, or for labels.
  Result<void> draw_color_and_depth(const mjData& data);
  Result<void> draw_labels(const mjData& data);

  // Last drawn image in MuJoCo's layout: 3 bytes per pixel, rows from the bottom.
  const std::vector<uint8_t>& color() const { return color_; }
  // Same, rows from the top.
  std::vector<uint8_t> upright_color() const;
  std::vector<uint32_t> labels() const;   // valid after draw_labels
  std::vector<float> depths_m() const;    // valid after draw_color_and_depth
  float far_m() const { return far_m_; }  // far plane, metres

 private:
  MujocoRenderer(const MujocoView& view, convert::MjcfModel model);
  Result<void> draw(const mjData& data, bool labels);

  MujocoView view_;
  convert::MjcfModel model_;  // copy with the rendering options of the view
  bool open_ = false;
  float near_m_, far_m_;
  mjvCamera camera_{};
  mjvOption option_{};
  mjvScene scene_{};
  mjrContext context_{};
  std::vector<uint8_t> color_;
  std::vector<float> depth_;
};

// Lockstep client for one camera of a model: publishes a frame and returns the renderer's image of it. One
// thread.
class RequestedImages {
 public:
  static Result<RequestedImages> open(const Simulation& simulation, const std::string& uri,
                                      const ImageSpec& spec, double timeout_s);

  // Publishes mjData unchanged and waits for its image.
  Result<Image> draw(const Simulation& simulation);
  Result<LabelledDepth> labelled(const fire3dv_image& image) const;
  static std::vector<uint8_t> rgb(const fire3dv_image& image);

 private:
  RequestedImages(Publisher publisher, InstanceLabels labels, uint64_t request, double timeout_s)
      : publisher_(std::move(publisher)),
        labels_(std::move(labels)),
        request_(request),
        timeout_s_(timeout_s) {}

  Publisher publisher_;
  InstanceLabels labels_;
  uint64_t request_;
  double timeout_s_;
};

}  // namespace fire3dv::mujoco

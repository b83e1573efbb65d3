// A MuJoCo simulation's end of its streams: put one call behind mj_step and renderers follow.
//
//   auto publisher = fire3dv::mujoco::Publisher::open(*model, {.uris = {"shm://mujoco"}, .rate_hz = 60});
//   loop { mj_step(model, data); publisher->publish(*model, *data); }
//
// Waits for no renderer, no network and no other process, but in wait_shown and wait_image. One thread at a
// time. The scene is what fire3dv-convert makes of the model's file, or scene_of() of the model in memory.
#pragma once

#include <fire3dv/client.hpp>

#include <mujoco/mujoco.h>

#include <atomic>
#include <string>
#include <vector>

#include "adapters/mujoco/frame_clock.h"
#include "adapters/mujoco/geom_looks.h"
#include "adapters/mujoco/moved_nodes.h"
#include "protocol/error.h"

namespace fire3dv::mujoco {

struct PublishOptions {
  std::vector<std::string> uris;
  Security security;
  double rate_hz = 0;  // frames a second of simulated time; 0: every call
  std::string adapter_name = "mujoco";
  std::string scene_uri;  // a hint for people and recordings
};

// What a camera sees, as one of FIRE-3DV's images (fire3dv/image.h).
struct ImageWish {
  std::string camera;  // of the model, by its name or number; or "free camera", where MuJoCo's viewer starts
  uint32_t width = 640, height = 480;            // pixels
  uint32_t outputs = FIRE3DV_IMAGE_COLOR_SRGB8;  // FIRE3DV_IMAGE_* bits
};

class Publisher {
 public:
  static Result<Publisher> open(const mjModel& model, const PublishOptions& options);

  // Whether publish() would send this step: what only a sent frame needs can be computed before.
  bool due(const mjData& data) const { return clock_.due(sim_time_ns(data)); }
  // False: this step is not due. Poses are those in data; call mj_forward where they must be of data's time.
  Result<bool> publish(const mjModel& model, const mjData& data);
  // The next frame is due, and nothing is interpolated into it: after a reset or a jump.
  void jump() { clock_.restart(); }

  // Lockstep: waits until each stream's last frame was shown. Returns early and without an error once stop is
  // set.
  Result<void> wait_shown(double timeout_s, const std::atomic<bool>& stop);

  // Asks the renderer of the first URI for an image of each frame that is published from now on. Returns the
  // request's number for the two below. Waits for nobody.
  Result<uint64_t> ask_images(const mjModel& model, const ImageWish& wish);
  // Lockstep: the image of the frame published last; older ones count as lost. Empty once stop is set.
  Result<Image> wait_image(uint64_t id, double timeout_s, const std::atomic<bool>& stop);
  // The next image that has come, or an empty one. A newer one takes the place of one that was not taken.
  Result<Image> take_image(uint64_t id);

  struct Link {
    std::string uri;
    fire3dv_status status{};
  };
  // What renderers have answered. Call it now and then.
  Result<std::vector<Link>> poll();

  const std::vector<std::string>& node_names() const { return nodes_.names(); }

 private:
  struct Target {
    std::string uri;
    Stream stream;
  };
  Publisher(const mjModel& model, convert::MjcfNames names, double rate_hz);
  Result<void> send_looks(const mjModel& model);
  static int64_t sim_time_ns(const mjData& data);

  convert::MjcfNames names_;
  MovedNodes nodes_;
  GeomLooks looks_;
  FrameClock clock_;
  std::vector<Target> targets_;
  std::vector<float> poses_;
  int bodies_, cameras_, lights_, tendons_, geoms_;
  uint64_t sequence_ = 0;  // as the library counts
};

// The model as one binary glTF file, its geoms nodes of their own, where data has it: write it where fire3dv
// can read it. name: of the root node. warnings: gets a sentence for each thing that is not in it.
Result<std::vector<std::byte>> scene_of(const mjModel& model, const mjData& data, const std::string& name,
                                        std::vector<std::string>& warnings);

}  // namespace fire3dv::mujoco

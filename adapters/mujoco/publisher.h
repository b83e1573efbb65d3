// Publisher of a MuJoCo simulation: one call after mj_step streams all poses to renderers.
//
//   auto publisher = fire3dv::mujoco::Publisher::open(*model, {.uris = {"shm://mujoco"}, .rate_hz = 60});
//   loop { mj_step(model, data); publisher->publish(*model, *data); }
//
// Only wait_shown and wait_image block. One thread at a time. The scene is fire3dv-convert's output for the
// model's file, or scene_of() of the model in memory.
#pragma once

#include <fire3dv/client.hpp>

#include <mujoco/mujoco.h>

#include <atomic>
#include <string>
#include <vector>

#include "adapters/mujoco/geom_appearance.h"
#include "adapters/mujoco/moved_nodes.h"
#include "adapters/mujoco/timing.h"
#include "protocol/base/error.h"

namespace fire3dv::mujoco {

struct PublishOptions {
  std::vector<std::string> uris;
  Security security;
  double rate_hz = 0;  // frames per second of simulated time; 0: every call
  std::string adapter_name = "mujoco";
  std::string scene_uri;  // informative, for users and recordings
};

// Image request for one camera (fire3dv/image.h).
struct ImageSpec {
  std::string camera;  // name or number of a model camera; or "free camera", the start view of MuJoCo's
                       // viewer
  uint32_t width = 640, height = 480;            // pixels
  uint32_t outputs = FIRE3DV_IMAGE_COLOR_SRGB8;  // FIRE3DV_IMAGE_* bits
};

class Publisher {
 public:
  static Result<Publisher> open(const mjModel& model, const PublishOptions& options);

  // Returns whether publish() would send this step, so that callers can skip work for unsent frames.
  bool due(const mjData& data) const { return clock_.due(sim_time_ns(data)); }
  // Publishes the poses in data; call mj_forward first where they must match data's time. Returns false when
  // this step is not due.
  Result<bool> publish(const mjModel& model, const mjData& data);
  // Marks the next frame as due and as a discontinuity, after a reset or a jump.
  void jump() { clock_.restart(); }

  // Lockstep: waits until every stream's last frame was shown. Returns early, without an error, once stop is
  // set.
  Result<void> wait_shown(double timeout_s, const std::atomic<bool>& stop);

  // Requests an image of each frame published from now on, from the renderer of the first URI. Returns the
  // request id for the two functions below. Does not block.
  Result<uint64_t> request_images(const mjModel& model, const ImageSpec& spec);
  // Lockstep: waits for the image of the last published frame; skipped older images count as lost. Empty once
  // stop is set.
  Result<Image> wait_image(uint64_t id, double timeout_s, const std::atomic<bool>& stop);
  // Returns the next image that has arrived, or an empty one. The newest image replaces one that was not
  // taken.
  Result<Image> take_image(uint64_t id);

  struct Link {
    std::string uri;
    fire3dv_status status{};
  };
  // Processes renderers' messages and returns their status. Call it regularly.
  Result<std::vector<Link>> poll();

  const std::vector<std::string>& node_names() const { return nodes_.names(); }

 private:
  struct Target {
    std::string uri;
    Stream stream;
  };
  Publisher(const mjModel& model, convert::MjcfNames names, double rate_hz);
  Result<void> send_appearance(const mjModel& model);
  static int64_t sim_time_ns(const mjData& data);

  convert::MjcfNames names_;
  StreamedNodes nodes_;
  GeomAppearance appearances_;
  FrameClock clock_;
  std::vector<Target> targets_;
  std::vector<float> poses_;
  int bodies_, cameras_, lights_, tendons_, geoms_;
  uint64_t sequence_ = 0;  // last frame's sequence, as the library counts
};

// Exports the model as a GLB with one node per geom, in the pose of data. name: of the root node. warnings:
// receives a message per unsupported feature.
Result<std::vector<std::byte>> scene_of(const mjModel& model, const mjData& data, const std::string& name,
                                        std::vector<std::string>& warnings);

}  // namespace fire3dv::mujoco

// Publisher of a MuJoCo simulation: one call after mj_step streams all poses to renderers.
//
//   auto publisher = fire3dv::mujoco::Publisher::open(*model, {.uris = {"shm://mujoco"}, .rate_hz = 60});
//   loop { mj_step(model, data); publisher->publish(*model, *data); }
//
// Only wait_shown and wait_image block. One thread at a time. The scene is fire3dv-convert's output for the
// model's file, or scene_of() of the model in memory.
#pragma once

#include <mujoco/mujoco.h>

#include <array>
#include <atomic>
#include <fire3dv/client.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "adapters/mujoco/joint_scalars.h"
#include "adapters/mujoco/markers.h"
#include "adapters/mujoco/timing.h"
#include "base/error.h"

namespace fire3dv::mujoco {

struct GeomEdit {
  size_t geom = 0;                           // index into MjcfNames::geoms
  std::optional<bool> visible;               // empty: unchanged
  std::optional<std::array<float, 4>> rgba;  // linear RGBA; empty: unchanged
};

// Change detection for geom appearance: colour, opacity and visible groups. MuJoCo does not signal changes,
// so each call compares. Changes become scene edits by geom name; scenes without geom nodes stay unchanged.
class GeomAppearance {
 public:
  // The scene must have been exported from the model in its current state.
  explicit GeomAppearance(const mjModel& model);

  // Returns changes since the last call. Without changes it allocates nothing.
  const std::vector<GeomEdit>& changes(const mjModel& model);

 private:
  struct Appearance {
    std::array<float, 4> rgba{};  // as displayed (sRGB)
    bool is_shown = false;
    bool is_in_scene = false;
  };
  std::vector<Appearance> appearances_;
  std::vector<GeomEdit> changes_;
};

// Nodes that MuJoCo moves, with their poses from mjData: bodies, cameras, lights and segments of spatial
// tendons. Names match the scene that is converted from the model (compiled/compiled_scene.h).
class StreamedNodes {
 public:
  StreamedNodes(const mjModel& model, const convert::MjcfNames& names);

  const std::vector<std::string>& names() const { return names_; }

  // Writes stream_from_node of all names(): 12 floats each, row-major, MuJoCo's world frame, Z up, metres.
  // mjData is used as it is: after mj_step it has the poses of the step's start. Allocates nothing after the
  // first call.
  void write(const mjModel& model, const mjData& data, std::vector<float>& poses);

 private:
  std::vector<std::string> names_;
  std::vector<int> lights_, tendons_;
  std::vector<convert::TendonPiece> pieces_;
  std::vector<convert::TendonFrame> frames_;
};

struct PublishOptions {
  std::vector<std::string> uris;
  Security security;
  double rate_hz = 0;  // frames per second of simulated time; 0: every call
  std::string adapter_name = "mujoco";
  std::string scene_uri;       // informative, for users and recordings
  uint32_t show = 0;           // Quantity bits: what to publish as markers
  bool joint_scalars = false;  // joint positions, velocities and efforts with each frame
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
  // set. say: receives a sentence about a wait of more than three seconds, once for each stream.
  Result<void> wait_shown(double timeout_s, const std::atomic<bool>& stop,
                          const std::function<void(const std::string& sentence)>& say);

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

  // Borrowed streams of all URIs, for inputs (interaction.h).
  std::vector<fire3dv_stream*> streams();

  const std::vector<std::string>& node_names() const { return nodes_.names(); }

 private:
  struct Target {
    std::string uri;
    Stream stream;
    bool has_reported_wait = false;
  };
  Publisher(const mjModel& model, convert::MjcfNames names, const PublishOptions& options);
  Result<void> send_appearance(const mjModel& model);
  Result<void> send_markers(const mjModel& model, const mjData& data);
  Result<void> send_joints(const mjData& data);
  static int64_t sim_time_ns(const mjData& data);

  convert::MjcfNames names_;
  StreamedNodes nodes_;
  GeomAppearance appearances_;
  SimulationMarkers markers_;
  std::optional<JointScalars> joints_;
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

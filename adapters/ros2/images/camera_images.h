// Cameras whose images go back into the ROS 2 graph: requests them from the renderer while somebody reads
// them, and hands each to its camera's thread. Used on the thread of the pose stream, which never waits here.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/images/camera_mount.h"
#include "adapters/ros2/images/camera_topics.h"
#include "adapters/ros2/images/optical_frames.h"
#include "base/error.h"

namespace fire3dv::ros2 {

class CameraImages {
 public:
  using Clock = std::chrono::steady_clock;
  // Mount of a frame; empty: tf does not have it yet.
  using FindMount = std::function<std::optional<CameraMount>(const std::string& frame)>;
  // Receives sentences; warnings begin with "warning: ".
  using Log = std::function<void(const std::string& sentence)>;

  static Result<std::unique_ptr<CameraImages>> open(const Participant& participant, const Names& names,
                                                    Log log);
  ~CameraImages();
  CameraImages(const CameraImages&) = delete;
  CameraImages& operator=(const CameraImages&) = delete;

  // Opens the topics of a camera and publishes its optical frame. Refuses a camera whose name, topic or frame
  // is another one's. The participant outlives this object.
  Result<void> add(const CameraSpec& camera);
  bool has(const std::string& name) const;
  size_t size() const { return cameras_.size(); }

  // Requests and cancels by demand, and hands arrived images on. stream: described, or requests wait. Call it
  // often: see poll_interval().
  void poll(fire3dv_stream* stream, const FindMount& find_mount, Clock::time_point now);
  // How long the caller may wait until the next poll(): short while images are on their way.
  std::chrono::milliseconds poll_interval() const;

  // One line for each camera that published images, for the end of the program.
  void log_counts();

 private:
  struct Camera;
  CameraImages(const Participant& participant, Names names, OpticalFrames frames, Log log);
  void update_request(Camera& camera, fire3dv_stream* stream, const FindMount& find_mount,
                      Clock::time_point now);
  void request(Camera& camera, fire3dv_stream* stream, const CameraMount& mount, uint32_t outputs);
  bool add_node(Camera& camera, fire3dv_stream* stream);
  void take_image(Camera& camera, fire3dv_stream* stream, Clock::time_point now);
  void report(Camera& camera, const std::string& problem);

  const Participant& participant_;
  Names names_;
  OpticalFrames frames_;
  Log log_;
  std::vector<std::unique_ptr<Camera>> cameras_;
  std::vector<CameraSpec> specs_;  // of cameras_
  Clock::time_point next_check_{};
};

}  // namespace fire3dv::ros2

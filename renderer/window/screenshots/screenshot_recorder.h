// Screenshot and video recorder of the window's image, without panels. File names contain the displayed
// frames; existing files are never replaced.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "renderer/capture/capture.h"
#include "renderer/gpu/device/device.h"
#include "renderer/sinks/video/video_sink.h"
#include "renderer/window/screenshots/screenshot_tiles.h"

namespace fire3dv::app {

class ScreenshotRecorder {
 public:
  // Creates the folder on first use.
  ScreenshotRecorder(gpu::Device& device, std::filesystem::path folder)
      : folder_(std::move(folder)), captures_(device) {}
  ~ScreenshotRecorder();  // deletes incomplete files unless finish() was called

  void request_screenshot() { screenshot_wanted_ = true; }
  void export_csv(std::string table);  // to a file beside the screenshots
  void toggle_video();
  bool records_video() const { return video_ != nullptr; }
  bool captures_image() const { return screenshot_wanted_ || video_ != nullptr; }  // the next one

  using Tag = capture::Provenance;
  // Call after the image's passes: records a copy if a screenshot or video frame is due.
  void record(gpu::Recorder& recorder, gpu::Image& image, Tag provenance);
  // Records a copy of one tile of a screenshot of this size. All tiles of a screenshot are recorded before
  // the next one's; the first is the one with kept_low (0, 0).
  void record_tile(gpu::Recorder& recorder, gpu::Image& image, Tag provenance, glm::uvec2 screenshot_px,
                   const ScreenshotTile& tile);
  void abandon_tiles() { mosaic_.reset(); }  // of a screenshot that will not be whole
  void submitted(uint64_t timeline_value) { captures_.submitted(timeline_value); }
  void deliver();  // passes finished images to writer threads
  void finish();   // call after the last deliver(): waits until all files are complete

  // Messages to the user since the last call.
  std::vector<std::string> take_log_messages();

 private:
  using Clock = std::chrono::steady_clock;
  // Screenshot of several tiles.
  struct Mosaic {
    glm::uvec2 size_px{0};
    uint64_t missing_px = 0;
    sinks::FrameImage image;
  };
  struct Use {
    bool screenshot = false;
    uint64_t video_frames = 0;  // an image is repeated if rendering is slower than the video
    uint64_t video = 0;         // number of their video
    std::shared_ptr<Mosaic> mosaic = nullptr;
    ScreenshotTile tile = {};
  };
  Result<std::filesystem::path> new_file(const char* ending);
  uint64_t video_frames_due(VkExtent2D extent);
  void end_video();
  void write(sinks::FrameImage&& image);
  void take_tile(Mosaic& mosaic, const ScreenshotTile& tile, sinks::FrameImage&& image);
  void note(std::string text) { notes_.push_back(std::move(text)); }

  const std::filesystem::path folder_;
  capture::CaptureQueue captures_;
  std::deque<Use> uses_;  // of the captures in flight, oldest first
  bool screenshot_wanted_ = false;
  std::shared_ptr<Mosaic> mosaic_;  // of the last tile

  std::unique_ptr<sinks::VideoSink> video_;
  std::filesystem::path video_path_;
  uint64_t video_number_ = 0;
  bool video_ending_ = false;  // ends after the images in flight
  VkExtent2D video_extent_{};
  Clock::time_point video_begun_;
  uint64_t video_frames_ = 0;

  std::vector<std::future<std::string>> writing_;  // each returns a message
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::app

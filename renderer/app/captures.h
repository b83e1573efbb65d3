// Pictures and videos that the user takes of what the window shows, without its panels: files that say which
// frames they show, and never replace others.
#pragma once

#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/gpu/device.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/video_sink.h"

namespace fire3dv::app {

class Captures {
 public:
  // The folder is made when it is needed.
  Captures(gpu::Device& device, std::filesystem::path folder)
      : folder_(std::move(folder)), readback_(device) {}
  ~Captures();  // finish() was called, or what is not whole goes

  void take_screenshot() { screenshot_wanted_ = true; }
  void toggle_video();
  bool records_video() const { return video_ != nullptr; }

  // What the image shows.
  struct Tag {
    uint64_t frame_index = 0;
    std::string camera;
    std::vector<state::FrameTag> shown;
  };
  // Behind the passes of an image: copies it where it is wanted.
  void record(gpu::Recorder& recorder, gpu::Image& image, Tag tag);
  void submitted(uint64_t timeline_value) { readback_.submitted(timeline_value); }
  void deliver();  // what is finished, to threads that write
  void finish();   // after the last deliver(): waits until all is in its files

  // Sentences for the user since the last call.
  std::vector<std::string> take_notes();

 private:
  using Clock = std::chrono::steady_clock;
  struct Wanted {
    Tag tag;
    bool screenshot = false;
    uint64_t video_frames = 0;  // a slow renderer's image stands for several
    uint64_t video = 0;         // number of the video that they are of
  };
  Result<std::filesystem::path> new_file(const char* ending);
  uint64_t video_frames_due(VkExtent2D extent);
  void end_video();
  void note(std::string text) { notes_.push_back(std::move(text)); }

  const std::filesystem::path folder_;
  passes::ReadbackBelt<Wanted> readback_;
  bool screenshot_wanted_ = false;

  std::unique_ptr<sinks::VideoSink> video_;
  std::filesystem::path video_path_;
  uint64_t video_number_ = 0;
  bool video_ending_ = false;  // when the images that are under way have come
  VkExtent2D video_extent_{};
  Clock::time_point video_begun_;
  uint64_t video_frames_ = 0;

  std::vector<std::future<std::string>> writing_;  // a sentence of each
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::app

#include "renderer/window/screenshots/screenshot_recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

#include "base/files.h"
#include "renderer/sinks/png.h"

namespace fire3dv::app {
namespace {

constexpr uint64_t kVideoFramesPerSecond = 30;

std::string local_time() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%d-%H%M%S", &parts);
  return text.data();
}

std::string write_screenshot(const std::filesystem::path& path, const sinks::FrameImage& image) {
  if (Result<void> written = sinks::write_png(path, image); !written) {
    ::unlink(path.c_str());  // removes the empty placeholder file
    return written.error().message;
  }
  return "screenshot " + path.string();
}

std::string write_table(const std::filesystem::path& path, const std::string& table) {
  const Result<void> written =
      write_whole_file(path, {reinterpret_cast<const uint8_t*>(table.data()), table.size()});
  if (written) return "scalars " + path.string();
  ::unlink(path.c_str());  // removes the empty placeholder file
  return written.error().message;
}

// Crops to even sizes, as video encoders require.
sinks::FrameImage even_sized(const sinks::FrameImage& image) {
  sinks::FrameImage even = image;
  even.width &= ~1u;
  even.height &= ~1u;
  if (even.width == image.width && even.height == image.height) return even;
  even.rgba8.clear();
  for (size_t y = 0; y < even.height; ++y) {
    const uint8_t* const row = image.rgba8.data() + y * image.width * 4;
    even.rgba8.insert(even.rgba8.end(), row, row + size_t{4} * even.width);
  }
  return even;
}

std::string end_file(std::unique_ptr<sinks::VideoSink> video, const std::filesystem::path& path) {
  Result<void> finished = video->finish();
  if (finished) return "video " + path.string();
  ::unlink(path.c_str());
  return finished.error().message;
}

}  // namespace

ScreenshotRecorder::~ScreenshotRecorder() {
  if (!video_) return;
  video_->abandon();
  ::unlink(video_path_.c_str());
}

// Creates the file immediately, so that concurrent writers choose different names.
Result<std::filesystem::path> ScreenshotRecorder::new_file(const char* ending) {
  std::error_code fault;
  std::filesystem::create_directories(folder_, fault);
  if (fault)
    return Error{"--screenshots " + folder_.string() + " cannot be made: " + fault.message() +
                 "; name another folder"};
  const std::string stem = (folder_ / ("fire3dv-" + local_time())).string();
  for (int number = 1; number < 10'000; ++number) {
    const std::filesystem::path path = stem + (number > 1 ? "-" + std::to_string(number) : "") + ending;
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file >= 0) {
      ::close(file);
      return path;
    }
    if (errno != EEXIST)
      return Error{"cannot write " + path.string() + ": " + system_reason(errno) +
                   "; --screenshots names another folder"};
  }
  return Error{folder_.string() + " has too many files of this second; --screenshots names another folder"};
}

void ScreenshotRecorder::export_csv(std::string table) {
  Result<std::filesystem::path> path = new_file(".csv");
  if (!path) return note(path.error().message);
  writing_.push_back(std::async(std::launch::async, write_table, std::move(*path), std::move(table)));
}

void ScreenshotRecorder::toggle_video() {
  if (video_) {
    video_ending_ = true;
    return;
  }
  Result<std::filesystem::path> path = new_file(".mp4");
  if (!path) return note(path.error().message);
  sinks::VideoSettings settings;
  settings.path = *path;
  settings.fps_numerator = kVideoFramesPerSecond;
  Result<std::unique_ptr<sinks::VideoSink>> video = sinks::VideoSink::open(settings);
  if (!video) {
    ::unlink(path->c_str());
    return note(video.error().message);
  }
  video_ = std::move(*video);
  video_path_ = std::move(*path);
  video_extent_ = {};
  video_frames_ = 0;
  ++video_number_;
  note("recording " + video_path_.string());
}

// Number of video frames until now: the video plays in real time, regardless of the frame rate.
uint64_t ScreenshotRecorder::video_frames_due(VkExtent2D extent) {
  if (!video_ || video_ending_) return 0;
  if (extent.width < 2 || extent.height < 2) {
    note("the video ends: a side of the window has less than 2 pixels; make it larger");
    video_ending_ = true;
    return 0;
  }
  if (video_frames_ == 0) {
    video_extent_ = extent;
    video_begun_ = Clock::now();
  }
  if (extent.width != video_extent_.width || extent.height != video_extent_.height) {
    note("the video ends: the image has another size");
    video_ending_ = true;
    return 0;
  }
  const std::chrono::duration<double> passed = Clock::now() - video_begun_;
  const auto due = static_cast<uint64_t>(passed.count() * kVideoFramesPerSecond) + 1;
  if (due <= video_frames_) return 0;
  // The video skips time in which the window was minimised.
  constexpr uint64_t kMaxAtOnce = kVideoFramesPerSecond;
  const uint64_t frames = std::min(due - video_frames_, kMaxAtOnce);
  video_begun_ +=
      std::chrono::nanoseconds((due - video_frames_ - frames) * 1'000'000'000 / kVideoFramesPerSecond);
  video_frames_ += frames;
  return frames;
}

void ScreenshotRecorder::record(gpu::Recorder& recorder, gpu::Image& image, Tag provenance) {
  const Use use{std::exchange(screenshot_wanted_, false), video_frames_due(image.extent), video_number_};
  if (!use.screenshot && use.video_frames == 0) return;
  captures_.record(recorder, image, std::move(provenance));
  uses_.push_back(use);
}

void ScreenshotRecorder::record_tile(gpu::Recorder& recorder, gpu::Image& image, Tag provenance,
                                     glm::uvec2 screenshot_px, const ScreenshotTile& tile) {
  if (tile.kept_low == glm::uvec2(0)) {
    mosaic_ = std::make_shared<Mosaic>();
    mosaic_->size_px = screenshot_px;
    mosaic_->missing_px = uint64_t{screenshot_px.x} * screenshot_px.y;
  }
  captures_.record(recorder, image, std::move(provenance));
  uses_.push_back({false, 0, 0, mosaic_, tile});
}

void ScreenshotRecorder::write(sinks::FrameImage&& image) {
  Result<std::filesystem::path> path = new_file(".png");
  if (!path) return note(path.error().message);
  writing_.push_back(std::async(std::launch::async, write_screenshot, std::move(*path), std::move(image)));
}

void ScreenshotRecorder::take_tile(Mosaic& mosaic, const ScreenshotTile& tile, sinks::FrameImage&& image) {
  constexpr size_t kPixelBytes = 4;
  const size_t row_bytes = kPixelBytes * mosaic.size_px.x;
  const std::vector<uint8_t> pixels = std::move(image.rgba8);
  if (mosaic.image.rgba8.empty()) {
    image.rgba8 = std::vector<uint8_t>(row_bytes * mosaic.size_px.y);
    mosaic.image = std::move(image);
    mosaic.image.width = mosaic.size_px.x;
    mosaic.image.height = mosaic.size_px.y;
  }
  const glm::uvec2 offset = tile.kept_low - tile.drawn_low;
  for (uint32_t y = 0; y < tile.kept_size.y; ++y) {
    const uint8_t* const from =
        pixels.data() + kPixelBytes * (size_t{offset.y + y} * tile.drawn_size.x + offset.x);
    std::copy_n(
        from, kPixelBytes * tile.kept_size.x,
        mosaic.image.rgba8.data() + row_bytes * (tile.kept_low.y + y) + kPixelBytes * tile.kept_low.x);
  }
  mosaic.missing_px -= uint64_t{tile.kept_size.x} * tile.kept_size.y;
  if (mosaic.missing_px == 0) write(std::move(mosaic.image));
}

void ScreenshotRecorder::deliver() {
  captures_.poll([&](sinks::FrameImage&& image) {
    const Use use = uses_.front();
    uses_.pop_front();
    if (use.mosaic) return take_tile(*use.mosaic, use.tile, std::move(image));
    if (use.screenshot) write(sinks::FrameImage(image));
    for (uint64_t i = 0; i < use.video_frames && video_ && use.video == video_number_; ++i) {
      if (Result<void> consumed = video_->consume(even_sized(image)); !consumed) {
        note(consumed.error().message);
        video_ending_ = true;
        break;
      }
    }
  });
  if (video_ending_ && captures_.in_flight() == 0) end_video();
}

void ScreenshotRecorder::end_video() {
  video_ending_ = false;
  if (!video_) return;
  if (video_frames_ == 0) {
    video_.reset();
    ::unlink(video_path_.c_str());
    return note("the video ended before there was an image for it");
  }
  writing_.push_back(std::async(std::launch::async, end_file, std::move(video_), video_path_));
}

void ScreenshotRecorder::finish() {
  deliver();
  end_video();
  for (std::future<std::string>& writing : writing_) note(writing.get());
  writing_.clear();
}

std::vector<std::string> ScreenshotRecorder::take_log_messages() {
  std::erase_if(writing_, [&](std::future<std::string>& writing) {
    if (writing.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    note(writing.get());
    return true;
  });
  return std::exchange(notes_, {});
}

}  // namespace fire3dv::app

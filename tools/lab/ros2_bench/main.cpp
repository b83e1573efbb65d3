// Cost of publishing images: fire3dv-ros2's camera threads beside a copy of the same bytes and a DDS write,
// each with a reader in another process. Prints rows of a table.
//
//   fire3dv-ros2-bench [--size 640x480] [--rate 30] [--seconds 5]

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fire3dv/client.hpp>
#include <functional>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/images/camera_topics.h"
#include "adapters/ros2/images/image_bytes.h"
#include "adapters/ros2/images/messages.h"
#include "base/command_line.h"
#include "base/image/jpeg_encoder.h"
#include "tools/lab/ros2_bench/reader_process.h"

namespace fire3dv::ros2 {
namespace {

constexpr const char* kBase = "/fire3dv_bench";

// A picture as a renderer's: smooth shading, edges and a little noise.
std::vector<uint8_t> picture(uint32_t width, uint32_t height) {
  std::vector<uint8_t> rgba(size_t{4} * width * height);
  uint32_t noise = 1;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      noise = noise * 1664525 + 1013904223;
      const uint32_t tile = ((x / 40 + y / 40) % 2) * 60;
      uint8_t* const pixel = &rgba[size_t{4} * (size_t{y} * width + x)];
      pixel[0] = static_cast<uint8_t>(x * 150 / width + tile + (noise >> 30));
      pixel[1] = static_cast<uint8_t>(y * 150 / height + tile + (noise >> 29) % 4);
      pixel[2] = static_cast<uint8_t>(60 + tile);
      pixel[3] = 255;
    }
  }
  return rgba;
}

struct Row {
  std::string name;
  size_t sent = 0, message_bytes = 0;
  double write_ms = 0;  // median: of the thread that writes
  double seconds = 0;
  ReaderProcess::Figures read;
};

void print(const Row& row) {
  const double lost =
      100 * (1 - static_cast<double>(row.read.count) / static_cast<double>(std::max<size_t>(row.sent, 1)));
  std::printf("| %s | %zu | %.1f | %.1f | %.1f %% | %.2f | %.2f | %.2f |\n", row.name.c_str(),
              row.message_bytes / 1000, static_cast<double>(row.sent) / row.seconds,
              static_cast<double>(row.read.count) / row.seconds, std::max(lost, 0.0), row.write_ms,
              row.read.median_ms, row.read.p99_ms);
  std::fflush(stdout);
}

struct Settings {
  uint32_t width = 640, height = 480;
  double rate_hz = 30, seconds = 5;
};

// Calls send(stamp) at the rate, or as fast as it returns (rate 0).
void pace(const Settings& settings, double rate_hz, const std::function<void(int64_t stamp_ns)>& send,
          Row& row) {
  const int64_t begin = now_ns();
  const auto end = begin + static_cast<int64_t>(settings.seconds * 1e9);
  std::vector<double> times_ms;
  int64_t due = begin;
  while (now_ns() < end) {
    if (rate_hz > 0) {
      due += static_cast<int64_t>(1e9 / rate_hz);
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::max<int64_t>(due - now_ns(), 0)));
    }
    const int64_t stamp = now_ns();
    send(stamp);
    times_ms.push_back(static_cast<double>(now_ns() - stamp) * 1e-6);
    ++row.sent;
  }
  row.seconds = static_cast<double>(now_ns() - begin) * 1e-9;
  row.write_ms = quantile(times_ms, 0.5);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the last ones arrive
}

// A copy of the message's bytes, and a DDS write: what any publisher of images does at least.
void bench_plain(const Settings& settings, double rate_hz, const std::string& name, bool compressed,
                 const std::vector<uint8_t>& bytes) {
  Row row{name};
  row.message_bytes = bytes.size();
  const auto participant = open_participant();
  const std::string topic = std::string(kBase) + "/plain";
  std::vector<uint8_t> copy(bytes.size());
  const std::string frame = "frame";
  const auto measure = [&](auto writer, auto message) {
    ReaderProcess reader(topic, compressed);
    reader.wait_matched();
    while (writer.reader_count() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    pace(
        settings, rate_hz,
        [&](int64_t stamp_ns) {
          std::memcpy(copy.data(), bytes.data(), bytes.size());
          message.header = header_of(stamp_ns, frame);
          message.data = sequence_of(copy);
          if (const Result<void> written = writer.write(message); !written) fail(written.error().message);
        },
        row);
    row.read = reader.finish();
  };
  if (compressed) {
    CompressedImageMessage message{};
    message.format = text_of("jpeg");
    measure(take(Writer<CompressedImageMessage>::open(*participant, topic, Profile::image)), message);
  } else {
    ImageMessage message{};
    message.width = settings.width;
    message.height = settings.height;
    message.step = 3 * settings.width;
    message.encoding = text_of("rgb8");
    measure(take(Writer<ImageMessage>::open(*participant, topic, Profile::image)), message);
  }
  print(row);
}

// The camera's topics, as its thread calls them, from the pixels that the renderer delivers.
void bench_camera(const Settings& settings, double rate_hz, const std::string& name, bool compressed,
                  std::vector<uint8_t>& rgba, size_t message_bytes) {
  Row row{name};
  row.message_bytes = message_bytes;
  const auto participant = open_participant();
  CameraSpec camera;
  camera.name = camera.parent_frame = "camera";
  camera.optical_frame = "camera_optical_frame";
  camera.topic = kBase;
  camera.compressed = true;
  auto topics = take(CameraTopics::open(*participant, Names(), camera));
  ReaderProcess reader(std::string(kBase) + (compressed ? "/image_raw/compressed" : "/image_raw"),
                       compressed);
  reader.wait_matched();
  while (topics.wanted_outputs() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const fire3dv_image_plane plane{FIRE3DV_IMAGE_COLOR_SRGB8, settings.width, settings.height,
                                  4 * settings.width, rgba.data()};
  fire3dv_image image{};
  image.width = settings.width;
  image.height = settings.height;
  image.plane_count = 1;
  image.planes = &plane;
  pace(
      settings, rate_hz,
      [&](int64_t stamp_ns) {
        image.sim_time_ns = stamp_ns;
        if (const Result<void> done = topics.publish(image); !done) fail(done.error().message);
      },
      row);
  row.read = reader.finish();
  print(row);
}

int run(int argc, char** argv) {
  Settings settings;
  std::string size = "640x480", read_raw, read_compressed;
  CLI::App app{"Measures what publishing images over DDS costs.", "fire3dv-ros2-bench"};
  set_help(app, "[OPTIONS]");
  app.footer("Each row has a reader in another process. Details: docs/benchmarks/ros2.md.");
  set_program_flags(app);
  fire3dv::OptionGroup group(app);
  group.add("--size", size, "WxH", "of the images");
  group.add("--rate", settings.rate_hz, "HZ", "images per second of the paced rows")
      ->check(number_between(0.1, 10000));
  group.add("--seconds", settings.seconds, "SECONDS", "duration of a row")->check(number_between(0.1, 3600));
  app.add_option("--read", read_raw, "")->group("");
  app.add_option("--read-compressed", read_compressed, "")->group("");
  try {
    app.parse(argc, argv);
    const auto parsed = parse_image_size(size);
    if (!parsed) throw CLI::ValidationError("--size", parsed.error().message);
    settings.width = parsed->first;
    settings.height = parsed->second;
  } catch (const CLI::ParseError& error) {
    return app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
  }
  if (!read_raw.empty()) return read_messages(read_raw, false);
  if (!read_compressed.empty()) return read_messages(read_compressed, true);

  std::vector<uint8_t> rgba = picture(settings.width, settings.height), rgb;
  const fire3dv_image_plane plane{FIRE3DV_IMAGE_COLOR_SRGB8, settings.width, settings.height,
                                  4 * settings.width, rgba.data()};
  pack_rgb8(plane, rgb);
  JpegEncoder encoder;
  const auto encoded =
      take(encoder.encode(rgba.data(), settings.width, settings.height, plane.row_stride, 95));
  const std::vector<uint8_t> jpeg(encoded.begin(), encoded.end());
  std::printf(
      "| %s | kB | sent/s | read/s | lost | write ms | read ms | p99 |\n|---|---|---|---|---|---|---|---|\n",
      size.c_str());
  for (const double rate_hz : {settings.rate_hz, 0.0}) {
    const std::string at =
        rate_hz > 0 ? ", " + std::to_string(static_cast<int>(rate_hz)) + " Hz" : ", unpaced";
    bench_plain(settings, rate_hz, "memcpy and DDS write, raw" + at, false, rgb);
    bench_camera(settings, rate_hz, "camera, image_raw" + at, false, rgba, rgb.size());
    bench_plain(settings, rate_hz, "memcpy and DDS write of a JPEG" + at, true, jpeg);
    bench_camera(settings, rate_hz, "camera, image_raw/compressed" + at, true, rgba, jpeg.size());
  }
  return 0;
}

}  // namespace
}  // namespace fire3dv::ros2

int main(int argc, char** argv) {
  return fire3dv::ros2::run(argc, argv);
}

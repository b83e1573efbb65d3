#include "tools/lab/bench/links/link_benches.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "fire3dv/client.h"
#include "fire3dv/image.h"
#include "protocol/transport/open.h"
#include "tools/lab/bench/links/simulator.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
namespace {

constexpr int kCallsARound = 64;
constexpr size_t kPoses = 100;

// Listener that drains its link like a renderer, without rendering.
class Reader {
 public:
  explicit Reader(std::unique_ptr<transport::ListenerLink> link)
      : link_(std::move(link)), thread_([this] {
          while (!stop_) {
            link_->poll([](const transport::LinkEvent&) {});
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
        }) {}
  ~Reader() {
    stop_ = true;
    thread_.join();
  }
  std::string uri() const { return link_->uri(); }

 private:
  std::unique_ptr<transport::ListenerLink> link_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct CloseStream {
  void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
};
using Stream = std::unique_ptr<fire3dv_stream, CloseStream>;

Stream open_stream(const std::string& uri) {
  fire3dv_options options{};
  options.struct_size = sizeof(options);
  options.adapter_name = "bench";
  Stream stream(fire3dv_open(uri.c_str(), &options));
  if (!stream) return nullptr;
  const std::vector<std::string> names = body_names(kPoses);
  std::vector<const char*> pointers;
  for (const std::string& name : names) pointers.push_back(name.c_str());
  fire3dv_description description{};
  description.struct_size = sizeof(description);
  description.node_names = pointers.data();
  description.node_count = pointers.size();
  if (fire3dv_describe(stream.get(), &description) != FIRE3DV_OK) return nullptr;
  fire3dv_status status{};
  status.struct_size = sizeof(status);
  for (int i = 0; i < 1000 && status.renderers == 0; ++i) {
    fire3dv_poll(stream.get(), &status);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return status.renderers ? std::move(stream) : nullptr;
}

double us_per_call(const std::function<bool(int)>& call, bool& good) {
  const int64_t begin_ns = fire3dv::monotonic_ns();
  for (int i = 0; i < kCallsARound; ++i) good = call(i) && good;
  return 1e-3 * static_cast<double>(fire3dv::monotonic_ns() - begin_ns) / kCallsARound;
}

// Returns false on failure; fire3dv_last_error() has the message.
bool measure(const char* link, const std::string& uri, int rounds) {
  const Stream stream = open_stream(uri);
  if (!stream) return false;
  std::vector<float> poses(12 * kPoses, 0);
  for (size_t i = 0; i < kPoses; ++i) poses[12 * i] = poses[12 * i + 5] = poses[12 * i + 10] = 1;
  fire3dv_image_request request{};
  request.struct_size = sizeof(request);
  request.width = request.height = 64;
  request.fx = request.fy = 64;
  request.cx = request.cy = 31.5f;
  request.outputs = FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32;
  uint64_t ids[kCallsARound] = {};
  int64_t sim_time_ns = 0;
  bool good = true;
  std::vector<double> publish_us, ask_us, ask_ratio, cancel_us, cancel_ratio;
  for (int round = 0; round < rounds && good; ++round) {
    publish_us.push_back(us_per_call(
        [&](int) {
          return fire3dv_publish(stream.get(), ++sim_time_ns, poses.data(), kPoses, 0) == FIRE3DV_OK;
        },
        good));
    ask_us.push_back(us_per_call(
        [&](int i) { return fire3dv_request_image(stream.get(), &request, &ids[i]) == FIRE3DV_OK; }, good));
    cancel_us.push_back(
        us_per_call([&](int i) { return fire3dv_cancel_image(stream.get(), ids[i]) == FIRE3DV_OK; }, good));
    ask_ratio.push_back(ask_us.back() / publish_us.back());
    cancel_ratio.push_back(cancel_us.back() / publish_us.back());
    // Gives the listener time to drain, so that messages do not pile up.
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  if (!good) return false;
  std::printf("| %s | publish %zu poses | %.2f | 1.00 |\n", link, kPoses, summarise(publish_us).median);
  std::printf("| %s | request an image | %.2f | %.2f |\n", link, summarise(ask_us).median,
              summarise(ask_ratio).median);
  std::printf("| %s | take that back | %.2f | %.2f |\n", link, summarise(cancel_us).median,
              summarise(cancel_ratio).median);
  return true;
}

}  // namespace

int request_bench(int rounds) {
  std::printf(
      "Calls of the client library that wait for nobody, a reader beside; medians of %d rounds of %d "
      "calls.\n\n"
      "| link | call | us a call | ratio |\n|---|---|---|---|\n",
      rounds, kCallsARound);
  const std::pair<const char*, std::string> links[] = {
      {"shm://", "shm://bench-" + std::to_string(::getpid())}, {"tcp://", "tcp://127.0.0.1:0"}};
  for (const auto& [name, uri] : links) {
    auto listener = transport::open_listener(uri);
    if (!listener) {
      std::fprintf(stderr, "fire3dv-bench: %s\n", listener.error().message.c_str());
      return 1;
    }
    const Reader reader(std::move(*listener));
    if (measure(name, reader.uri(), rounds)) continue;
    std::fprintf(stderr, "fire3dv-bench: %s: %s\n", name, fire3dv_last_error());
    return 1;
  }
  return 0;
}

}  // namespace fire3dv::bench

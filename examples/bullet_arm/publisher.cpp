#include "examples/bullet_arm/publisher.h"

#include <chrono>

#include "examples/bullet_arm/frames.h"

namespace bullet_arm {
namespace {

std::string failed(const char* what, const std::string& uri) {
  return std::string(what) + " " + uri + ": " + fire3dv_last_error();
}

}  // namespace

std::optional<std::string> Publisher::open(const std::vector<std::string>& uris) {
  fire3dv_options options{};
  options.struct_size = sizeof options;
  options.adapter_name = "bullet_arm";
  for (const std::string& uri : uris) {
    Stream stream{uri, std::unique_ptr<fire3dv_stream, Close>(fire3dv_open(uri.c_str(), &options))};
    if (!stream.handle) return failed("cannot open", uri);
    streams_.push_back(std::move(stream));
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::describe(const std::vector<std::string>& names, double rate_hz,
                                               const std::string& scene) {
  std::vector<const char*> pointers;
  for (const std::string& name : names) pointers.push_back(name.c_str());
  fire3dv_description description{};
  description.struct_size = sizeof description;
  description.node_names = pointers.data();
  description.node_count = pointers.size();
  description.world_from_stream = kWorldFromStream.data();
  description.body_from_node = kBodyFromNode.data();
  description.body_from_node_count = 1;
  description.nominal_rate_hz = rate_hz;
  description.scene_uri = scene.empty() ? nullptr : scene.c_str();
  for (Stream& stream : streams_) {
    if (fire3dv_describe(stream.handle.get(), &description) != FIRE3DV_OK)
      return failed("cannot describe", stream.uri);
  }
  sequence_ = 0;
  return std::nullopt;
}

std::optional<std::string> Publisher::publish(int64_t sim_time_ns, const std::vector<float>& poses,
                                              bool discontinuity) {
  ++sequence_;
  const uint32_t flags = discontinuity ? FIRE3DV_FRAME_DISCONTINUITY : 0;
  for (Stream& stream : streams_) {
    if (fire3dv_publish(stream.handle.get(), sim_time_ns, poses.data(), poses.size() / 12, flags) !=
        FIRE3DV_OK) {
      return failed("cannot publish to", stream.uri);
    }
  }
  return std::nullopt;
}

std::optional<std::string> Publisher::wait_shown(double timeout_s, const std::atomic<bool>& stop) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  for (Stream& stream : streams_) {
    for (;;) {
      if (stop) return std::nullopt;
      const int result =
          fire3dv_wait_ack(stream.handle.get(), sequence_, 100);  // short, so that Ctrl-C is heard
      if (result == FIRE3DV_OK) break;
      if (result != FIRE3DV_ERROR_TIMEOUT) return failed("cannot wait for", stream.uri);
      if (std::chrono::steady_clock::now() >= deadline) {
        return "no renderer on " + stream.uri + " has shown frame " + std::to_string(sequence_) +
               " in time: start one with --listen, or give a longer --ack-timeout";
      }
    }
  }
  return std::nullopt;
}

std::vector<Publisher::Link> Publisher::poll() {
  std::vector<Link> links;
  for (Stream& stream : streams_) {
    Link link{stream.uri, {}};
    link.status.struct_size = sizeof link.status;
    if (fire3dv_poll(stream.handle.get(), &link.status) == FIRE3DV_OK) links.push_back(std::move(link));
  }
  return links;
}

}  // namespace bullet_arm

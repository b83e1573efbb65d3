// Fixture of the client library's tests: a renderer's end of a link in the test's own thread, and unique
// names.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fire3dv/client.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"

namespace fire3dv::test {

inline std::string unique_shm_uri() {
  static int count = 0;
  return "shm://test-" + std::to_string(::getpid()) + "-" + std::to_string(count++);
}

// Maps "shm", "tcp" or "udp" to a URI for a listener.
inline std::string listener_uri(const std::string& scheme) {
  return scheme == "shm" ? unique_shm_uri() : scheme + "://127.0.0.1:0";
}

// Returns a URI without a listener.
inline std::string silent_uri(const std::string& scheme) {
  auto listener = transport::open_listener(listener_uri(scheme));
  EXPECT_TRUE(listener.ok()) << listener.error().message;
  return listener.ok() ? (*listener)->uri() : "";
}

inline fire3dv_status poll(fire3dv_stream* stream) {
  fire3dv_status status{};
  status.struct_size = sizeof status;
  EXPECT_EQ(fire3dv_poll(stream, &status), FIRE3DV_OK) << fire3dv_last_error();
  return status;
}

inline int describe(fire3dv_stream* stream, const std::vector<const char*>& names) {
  fire3dv_description description{};
  description.struct_size = sizeof description;
  description.node_names = names.data();
  description.node_count = names.size();
  return fire3dv_describe(stream, &description);
}

// Renderer's end of a link; collects the received messages.
struct Renderer {
  std::unique_ptr<transport::ListenerLink> link;
  transport::PeerId peer = 0;
  std::vector<wire::StreamDescription> descriptions;
  uint64_t sequence = 0;  // of the newest pose message
  std::vector<wire::Affine3x4> poses;
  std::vector<bool> have_pose;
  std::vector<wire::Pong> pongs;
  bool ended = false;  // after a goodbye or a disconnect

  explicit Renderer(const std::string& uri) {
    auto opened = transport::open_listener(uri);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (opened.ok()) link = std::move(*opened);
  }

  void poll() {
    link->wait(std::chrono::milliseconds(1));
    link->poll([&](const transport::LinkEvent& event) {
      if (event.kind == transport::LinkEvent::Kind::disconnected) ended = true;
      if (event.kind != transport::LinkEvent::Kind::pose && event.kind != transport::LinkEvent::Kind::control)
        return;
      peer = event.peer;
      const auto message = decoder_.decode(event.message);
      ASSERT_TRUE(message.ok()) << message.error().message;
      if (const auto* m = std::get_if<wire::StreamDescription>(&*message)) descriptions.push_back(*m);
      if (const auto* m = std::get_if<wire::PoseFrameView>(&*message)) take(*m);
      if (const auto* m = std::get_if<wire::Pong>(&*message)) pongs.push_back(*m);
      if (std::holds_alternative<wire::Goodbye>(*message)) ended = true;
    });
  }

  template <typename Message>
  void send(const Message& message) {
    link->send(peer, wire::encode(message));
  }

  bool has_whole_frame() const {
    return !have_pose.empty() && std::find(have_pose.begin(), have_pose.end(), false) == have_pose.end();
  }

 private:
  wire::Decoder decoder_;

  void take(const wire::PoseFrameView& frame) {
    if (frame.header.sequence != sequence) {
      sequence = frame.header.sequence;
      poses.assign(frame.node_count, {});
      have_pose.assign(frame.node_count, false);
    }
    for (size_t i = 0; i < frame.poses.size(); ++i) {
      poses[frame.first_node + i] = frame.poses[i];
      have_pose[frame.first_node + i] = true;
    }
  }
};

// Calls step until it returns true. The limit is a hang limit: loopback takes milliseconds.
inline bool repeat_until(const std::function<bool()>& step) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < end) {
    if (step()) return true;
  }
  return false;
}

}  // namespace fire3dv::test

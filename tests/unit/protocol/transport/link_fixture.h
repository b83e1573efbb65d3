// Fixture of transport tests: verifiable messages, and a listener that records its events. Tests count
// events; waits end with the event, and their limits are hang limits.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "protocol/transport/open.h"

namespace fire3dv::transport::test {

using Kind = LinkEvent::Kind;

constexpr std::chrono::seconds kHangLimit{60};

inline std::string unique_shm_uri(const char* what) {
  static int number = 0;
  return "shm://test-" + std::string(what) + "-" + std::to_string(::getpid()) + "-" +
         std::to_string(++number);
}

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}
inline std::string text_of(std::span<const std::byte> bytes) {
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}
inline wire::MessagePieces message_of(std::string_view text) {
  return {bytes_of(text), {}};
}

struct Event {
  Kind kind;
  PeerId peer;
  std::string text;  // the message, or the event's text
};

struct Listener {
  std::unique_ptr<ListenerLink> link;
  std::vector<Event> events;

  explicit Listener(const std::string& uri, ListenerOptions options = {}) {
    auto opened = open_listener(uri, options);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (opened.ok()) link = std::move(*opened);
  }

  void poll() {
    link->poll([this](const LinkEvent& event) {
      const bool has_message = event.kind == Kind::pose || event.kind == Kind::control;
      events.push_back(
          {event.kind, event.peer, has_message ? text_of(event.message) : std::string(event.text)});
    });
  }

  // Polls until `done` holds.
  bool poll_until(const std::function<bool()>& done) {
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (!done()) {
      if (std::chrono::steady_clock::now() > until) return false;
      link->wait(std::chrono::milliseconds(5));
      poll();
    }
    return true;
  }

  size_t count(Kind kind) const {
    size_t found = 0;
    for (const Event& event : events) found += event.kind == kind;
    return found;
  }
  bool saw(Kind kind, std::string_view text) const {
    for (const Event& event : events)
      if (event.kind == kind && event.text == text) return true;
    return false;
  }
  bool saw_part(Kind kind, std::string_view text) const {
    for (const Event& event : events)
      if (event.kind == kind && event.text.find(text) != std::string::npos) return true;
    return false;
  }
  std::string last(Kind kind) const {
    for (auto event = events.rbegin(); event != events.rend(); ++event)
      if (event->kind == kind) return event->text;
    return {};
  }
  PeerId peer() const { return events.empty() ? 0 : events.back().peer; }
};

// Observer of arrivals; see ListenerOptions::on_arrival.
class Arrivals {
 public:
  OnArrival observer() {
    return [this](const LinkEvent& event) {
      const std::lock_guard lock(mutex_);
      if (event.kind == Kind::pose) poses_.push_back(text_of(event.message));
      ends_ += event.kind == Kind::disconnected;
    };
  }
  std::vector<std::string> poses() const {
    const std::lock_guard lock(mutex_);
    return poses_;
  }
  size_t ends() const {
    const std::lock_guard lock(mutex_);
    return ends_;
  }
  // Waits without polling the link.
  static bool wait_until(const std::function<bool()>& done) {
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (!done()) {
      if (std::chrono::steady_clock::now() > until) return false;
      ::usleep(200);
    }
    return true;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> poses_;
  size_t ends_ = 0;
};

inline std::unique_ptr<PublisherLink> open_publisher_or_fail(const std::string& uri,
                                                             PublisherOptions options = {}) {
  auto opened = open_publisher(uri, options);
  EXPECT_TRUE(opened.ok()) << opened.error().message;
  return opened.ok() ? std::move(*opened) : nullptr;
}

// Publishes `text` repeatedly until the listener has it: a link may drop any single frame.
inline bool publish_until_seen(PublisherLink& publisher, Listener& listener, std::string_view text) {
  return listener.poll_until([&] {
    if (listener.saw(Kind::pose, text)) return true;
    publisher.publish(message_of(text));
    return false;
  });
}

inline bool poll_until_reply(PublisherLink& publisher, std::string_view text) {
  const auto until = std::chrono::steady_clock::now() + kHangLimit;
  std::vector<std::byte> message;
  while (std::chrono::steady_clock::now() < until) {
    if (!publisher.poll(message)) {
      ::usleep(200);
      continue;
    }
    if (text_of(message) == text) return true;
  }
  return false;
}

}  // namespace fire3dv::transport::test

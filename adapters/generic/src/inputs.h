// Declared inputs of a stream, and the queue of events that people caused with them. Used under the stream's
// lock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "protocol/wire/input.h"

namespace fire3dv::client {

class Inputs {
 public:
  static constexpr size_t kMaxQueued = 1024;                 // events; ends of drags have room beyond it
  static constexpr size_t kMaxHolds = 64;                    // drags at the same time
  static constexpr size_t kMaxSources = 64;                  // renderers whose sequences are known
  static constexpr uint64_t kHoldTimeoutNs = 5'000'000'000;  // a renderer repeats the moves of a drag

  bool is_declared(const std::string& name) const { return declared_.contains(name); }
  size_t count() const { return declared_.size(); }
  void declare(const std::string& name, const wire::Input& input);
  // Ends drags by that input, with an event.
  void clear(const std::string& name);
  // Drops events other than ends of drags, and ends the drags that are held: their nodes are those of the
  // description before.
  void restart_epoch();

  // Queues an event, or drops it (counted): of another epoch, repeated, of an undeclared input, of an action
  // or value that the input does not take, or beyond a limit.
  void on(wire::InputEvent event, uint64_t epoch, uint32_t node_count, uint64_t now_ns);
  // Ends drags of which nothing was heard for kHoldTimeoutNs, or for 1 s without a connected renderer.
  void end_lost_drags(uint64_t now_ns, bool has_renderers);
  bool has_drags() const { return !holds_.empty(); }

  struct Taken {
    wire::InputEvent event;
    wire::InputKind kind{};
    uint64_t lost = 0;  // events dropped since the one taken before
    // Declaration with the value of the event; empty if that does not change it.
    std::optional<wire::Input> changed;
  };
  std::optional<Taken> take();

 private:
  using Holder = std::tuple<std::string, uint64_t, uint32_t>;  // input, source, viewer
  struct Hold {
    uint32_t node = 0;
    uint64_t heard_ns = 0;
  };
  struct Source {
    uint64_t sequence = 0;
    uint64_t heard_ns = 0;
  };
  bool is_new(const wire::InputEvent& event, uint64_t now_ns);
  bool begin(Holder holder, const wire::InputEvent& event, uint64_t now_ns);
  bool hold(wire::InputEvent& event, uint64_t now_ns);
  void drop_older(const wire::InputEvent& event, wire::InputKind kind);
  void push_end(const Holder& holder, uint32_t node);

  std::map<std::string, wire::Input> declared_;
  std::deque<wire::InputEvent> queue_;
  std::map<Holder, Hold> holds_;
  std::map<uint64_t, Source> sources_;
  uint64_t epoch_ = 0, lost_ = 0;
};

}  // namespace fire3dv::client

// State that the connections of the live view share, and the exchange of events with the frame loop.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/browser/server/server.h"

namespace fire3dv::serve {

class ViewerSocket;

struct Hub {
  // Constant after the start.
  ServerLimits limits;
  Tokens tokens;

  // Owned by the server's thread.
  std::map<ViewerId, std::weak_ptr<ViewerSocket>> sockets;  // with and without a token; by age
  ViewerId next_viewer = 1;

  // Events to the frame loop.
  struct Viewer {
    Access access = Access::none;
    size_t pending = 0;  // messages that the frame loop has not taken
    bool is_paused = false;
  };
  mutable std::mutex mutex;
  std::vector<Event> events;
  std::map<ViewerId, Viewer> viewers;

  // False: too many viewers.
  bool join(ViewerId viewer, Access access) {
    const std::scoped_lock lock(mutex);
    if (viewers.size() >= limits.max_viewers) return false;
    viewers[viewer] = {access, 0, false};
    events.push_back({Event::Kind::joined, viewer, access, {}});
    return true;
  }
  void leave(ViewerId viewer) {
    const std::scoped_lock lock(mutex);
    if (viewers.erase(viewer) == 0) return;
    std::erase_if(events, [&](const Event& event) { return event.viewer == viewer; });
    events.push_back({Event::Kind::left, viewer, Access::none, {}});
  }
  // False: the socket must pause until it is resumed.
  bool push(ViewerId viewer, ClientMessage&& message) {
    const std::scoped_lock lock(mutex);
    const auto known = viewers.find(viewer);
    if (known == viewers.end()) return true;
    events.push_back({Event::Kind::message, viewer, known->second.access, std::move(message)});
    known->second.is_paused = ++known->second.pending >= limits.max_pending_messages;
    return !known->second.is_paused;
  }
};

}  // namespace fire3dv::serve

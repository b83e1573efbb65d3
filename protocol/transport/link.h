// Links: transport of whole messages between one publisher (a simulator's adapter) and any number of
// renderers. Messages are opaque bytes, either poses or control messages. A newer pose replaces an older one;
// control messages are never dropped silently. open.h opens links by URI.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/peer_budget.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport {

// Reasons for rejecting traffic or peers. cause_name() returns the text for messages and metrics.
enum class Cause : uint8_t {
  malformed,        // foreign or inconsistent bytes
  version,          // another transport version, or an unknown message kind
  oversize,         // exceeds the size limit
  full,             // peer limit reached
  silent,           // no greeting in time, or no traffic for too long
  unknown_session,  // datagrams of an unknown session, or from another address than the session's
  replayed,         // duplicate datagram, or too old for the replay window
  bad_key,          // wrong key, or no trusted certificate
  unread,           // control messages that the receiver does not read in time
  no_memory,        // memory limit of all peers together
  lapped,           // control messages overwritten before they were read
  system,           // operating system error
};
constexpr size_t kCauseCount = 12;
inline const char* cause_name(Cause cause) {
  constexpr const char* kNames[] = {"malformed", "version",         "oversize", "full",
                                    "silent",    "unknown_session", "replayed", "bad_key",
                                    "unread",    "no_memory",       "lapped",   "system"};
  static_assert(std::size(kNames) == kCauseCount);
  return kNames[static_cast<size_t>(cause)];
}

// Shared ownership: tens of megabytes are neither copied nor freed while a lock is held.
using SharedBytes = std::shared_ptr<const wire::Bytes>;

struct LinkStats {
  uint64_t messages_sent = 0;  // poses handed to the link (publisher) or replies (listener)
  uint64_t messages_received = 0;
  uint64_t bytes_sent = 0;
  uint64_t bytes_received = 0;
  uint64_t poses_dropped = 0;  // poses replaced by a newer one before they were sent or polled
  // Publisher: frames with a dropped message; udp listener: frames incomplete when a newer one was whole.
  uint64_t frames_dropped = 0;
  uint64_t images_sent = 0;      // listener only
  uint64_t images_received = 0;  // publisher only: delivered to the caller
  uint64_t images_dropped = 0;   // replaced by a newer one of their request, or dropped for lack of space
  uint64_t rejected = 0;         // malformed or unwanted traffic, sum over all causes
  std::array<uint64_t, kCauseCount> rejected_by_cause{};
  uint32_t peers = 0;  // current readers or connections
};

// --- publisher side ---

// Thread safety: one thread publishes and polls; stats() may be called from any thread.
class PublisherLink {
 public:
  virtual ~PublisherLink() = default;

  // Size limit of a pose message. The caller splits longer frames into parts.
  virtual size_t max_pose_message_bytes() const = 0;

  // Sets the encoded StreamDescription, which every joiner receives before its first pose. The link stores a
  // copy and repeats it as the medium requires. Replaces an earlier one.
  virtual Result<void> set_description(std::span<const std::byte> message) = 0;

  // Sets the newest control message of a key. Joiners receive all states after the description, in the order
  // of their last put; slow peers may miss replaced values. set_description() drops all states. Never blocks.
  virtual Result<void> put_state(uint64_t key, SharedBytes message) = 0;

  // Publishes one pose message. Never blocks on a renderer, a socket, a contended lock or memory. last_part
  // is false for all but the last part of a split frame. Returns false if the message was dropped (counted).
  // A queued message that a newer one replaces is counted later.
  virtual bool publish(const wire::MessagePieces& message, bool last_part = true) noexcept = 0;

  // False: frames are always sent whole, since no base frame can be presumed.
  virtual bool takes_partial_frames() const { return false; }
  // Publishes one frame in two forms: `partial` has the changes, `whole` all poses, split as for publish().
  // The link sends `partial` only if no base frame can be missing, and makes the last frame before a pause
  // arrive whole. Otherwise same as publish().
  virtual bool publish_partial(const wire::MessagePieces& /*partial*/,
                               std::span<const wire::MessagePieces> whole) noexcept {
    bool is_taken = true;
    for (size_t part = 0; part < whole.size(); ++part)
      is_taken = publish(whole[part], part + 1 == whole.size()) && is_taken;
    return is_taken;
  }

  // Sends one control message (Ping, Goodbye) to the connected peers. Best effort; never blocks.
  virtual void send_control(std::span<const std::byte> message) noexcept = 0;

  // Receives the next message of the back channel (Welcome, Ack, Pong), or returns false. Never blocks.
  // Reuses the vector's memory.
  virtual bool poll(std::vector<std::byte>& message) = 0;

  // Reserves memory for image blocks (wire::ImageBlock) of this size: one per request in flight and one per
  // request held by the caller. The error contains the reason and the remedy.
  virtual Result<void> make_room_for_images(size_t /*block_bytes*/, size_t /*requests*/) {
    return Error{"images do not come back over this link; use shm:// or tcp://"};
  }
  // Receives the next image or nothing; per request only the newest. Never blocks. The block stays unchanged
  // as long as `memory` is held, on any thread, even after the link is destroyed.
  struct Image {
    std::shared_ptr<const void> memory;
    std::span<const std::byte> block;
    bool is_lent = false;  // part of a larger memory of the link, which it keeps
  };
  virtual std::optional<Image> poll_image() { return {}; }

  // Reason why no renderer is connected, in one sentence, if known; otherwise empty.
  virtual std::string problem() const { return {}; }

  virtual LinkStats stats() const = 0;
};

// --- renderer side ---

using PeerId = uint64_t;  // unique within one listener for the life of the process, never reused

struct LinkEvent {
  enum class Kind { connected, pose, control, disconnected, note };
  Kind kind;
  PeerId peer = 0;
  std::span<const std::byte> message;  // pose, control; valid during the callback only
  std::string_view text;               // disconnected: reason; note: one-time message to the user
  int64_t received_ns = 0;             // pose, control: monotonic time of arrival; 0: now
  uint64_t overtaken = 0;  // pose: older poses of the peer that it replaced before they were delivered
};
// Observer of arrivals, see ListenerOptions::on_arrival.
using OnArrival = std::function<void(const LinkEvent&)>;

enum class Delivery {
  newest,  // between two polls, at most the newest whole frame of each peer
  all,     // every available frame, in order; for lockstep and recording
};

// Thread safety: one thread polls and sends; stats() may be called from any thread.
class ListenerLink {
 public:
  virtual ~ListenerLink() = default;

  // Delivers all events since the last poll, in order per peer. Never blocks.
  virtual void poll(const std::function<void(const LinkEvent&)>& on_event) = 0;

  // Waits until poll() may have events, or until the timeout.
  virtual void wait(std::chrono::nanoseconds timeout) = 0;

  // Sends one control message to one peer. Best effort; never blocks; a disconnected peer is no error.
  virtual void send(PeerId peer, std::span<const std::byte> message) = 0;

  // Whether events of people (wire::InputEvent) may be sent: the peer is local, or known, or was allowed by
  // the user, and it gets them in order.
  virtual bool carries_input() const { return false; }

  virtual bool carries_images() const { return false; }
  // Sends an image to one peer: its encoded ImageFrame, and pixels that `fill` writes directly into the send
  // buffer. Never blocks: replaces an unsent older image of the request. Returns false if the image is
  // dropped (counted); `fill` may then not have been called.
  using FillPixels = std::function<void(std::span<std::byte> pixels)>;
  virtual bool send_image(PeerId, uint64_t /*request*/, std::span<const std::byte> /*head*/,
                          size_t /*pixel_bytes*/, const FillPixels&) {
    return false;
  }

  // Budget of this peer's messages, valid from its `connected` to its `disconnected` event. Null: the link
  // charges nothing, and the caller creates its own budget.
  virtual std::shared_ptr<PeerBudget> budget(PeerId) const { return nullptr; }

  // Marks the peer's stream as described and accepted. A full listener may replace unaccepted peers by new
  // ones.
  virtual void accept(PeerId) {}

  // Pauses a peer: poll() leaves its messages in the link, which applies its limits (stops reading, or drops
  // older poses). For receivers with a backlog from an earlier poll().
  virtual void pause_peer(PeerId, bool /*is_paused*/) {}

  // Ends ListenerOptions::on_arrival after all messages that have arrived until now. For the end of a
  // recording.
  virtual void end_arrivals() {}

  virtual LinkStats stats() const = 0;

  // URI at which publishers reach this listener (with the assigned port if port 0 was given).
  virtual std::string uri() const = 0;
};

}  // namespace fire3dv::transport

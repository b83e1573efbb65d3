// A link carries whole messages between one publisher (a simulator's adapter) and any number of renderers. It
// knows nothing of poses: a message is bytes and one of two kinds. Newest wins for pose messages; control
// messages are never dropped silently. The three real links are opened by URI (open.h).
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport {

// Why something that came, or somebody who came, was turned away. cause_name() has the words for people and
// metrics.
enum class Cause : uint8_t {
  malformed,        // bytes that are not ours, or contradict themselves
  version,          // another version of the transport, or a kind that this one does not know
  oversize,         // longer than is allowed
  full,             // as many peers as allowed are there
  silent,           // no greeting in time, or nothing at all for too long
  unknown_session,  // datagrams of a session that is not known here, or comes from elsewhere
  replayed,         // a datagram that came before, or too late to tell
  bad_key,          // not sealed with our key, or no certificate that we trust
  unread,           // control messages that nobody takes in time
  no_memory,        // the memory set aside for all peers together is used up
  lapped,           // control messages that were overwritten before they were read
  system,           // the operating system refused
};
constexpr size_t kCauseCount = 12;
const char* cause_name(Cause cause);

// Shared, so that neither copy nor release of tens of megabytes happens while a lock is held.
using SharedBytes = std::shared_ptr<const wire::Bytes>;

struct LinkStats {
  uint64_t messages_sent = 0;  // pose messages handed to the link (publisher) or replies (listener)
  uint64_t messages_received = 0;
  uint64_t bytes_sent = 0;
  uint64_t bytes_received = 0;
  uint64_t poses_dropped = 0;    // pose messages replaced by a newer one before they left or were polled
  uint64_t frames_dropped = 0;   // publisher: frames of which at least one message was dropped; udp listener:
                                 // those that had not come whole when a newer one had
  uint64_t images_sent = 0;      // listener
  uint64_t images_received = 0;  // publisher: handed to the caller
  uint64_t images_dropped = 0;   // replaced by a newer one of their request, or without room
  uint64_t rejected = 0;         // malformed or unwelcome traffic, all causes together
  std::array<uint64_t, kCauseCount> rejected_by_cause{};
  uint32_t peers = 0;  // readers or connections now
};

// --- the simulator's end
// ---------------------------------------------------------------------------------------------

// Thread-safety: one thread publishes and polls; stats() may be called from any thread.
class PublisherLink {
 public:
  virtual ~PublisherLink() = default;

  // The largest pose message that the link takes. A longer frame is split into parts by the caller.
  virtual size_t max_pose_message_bytes() const = 0;

  // Control state that every joiner gets before its first pose message: the encoded StreamDescription. The
  // link keeps a copy and repeats it as its medium needs. Replaces an earlier one.
  virtual Result<void> set_description(std::span<const std::byte> message) = 0;

  // Control state of which the newest message of each key counts. Every joiner gets these after the
  // description, in the order in which they were put last; a peer that is slow may be spared those that were
  // replaced meanwhile. They belong to the description: set_description drops them all. Never waits.
  virtual Result<void> put_state(uint64_t key, SharedBytes message) = 0;

  // Hands one pose message to the link. Never waits: not for a renderer, a socket, a lock that another thread
  // may hold for long, or memory. last_part is false for all but the last part of a split frame. Returns
  // false when the message was dropped (counted); a message that waits in the link and is overtaken by a
  // newer one is counted later.
  virtual bool publish(const wire::MessagePieces& message, bool last_part = true) noexcept = 0;

  // False: every frame has to be whole here.
  virtual bool takes_partial_frames() const { return true; }
  // Hands over one frame of which `partial` alone says what changed, and `whole`, cut into parts as publish()
  // takes them, says all. The link sends `partial` where nothing it builds on can be missing, and sees to it
  // that the last frame before a pause arrives whole. Else as publish().
  virtual bool publish_partial(const wire::MessagePieces& partial,
                               std::span<const wire::MessagePieces> whole) noexcept = 0;

  // Sends one control message (Ping, Goodbye) to whoever is connected now. Best effort; never waits.
  virtual void send_control(std::span<const std::byte> message) noexcept = 0;

  // Next message of the back channel (Welcome, Ack, Pong), or false. Never waits. Reuses the vector's memory.
  virtual bool poll(std::vector<std::byte>& message) = 0;

  // Makes room for images that come back, blocks (wire/image_block.h) of so many bytes: of `requests`
  // requests at once, and as many again that the caller holds. An error says why that cannot be, and what
  // would help.
  virtual Result<void> make_room_for_images(size_t block_bytes, size_t requests);
  // The next image, or nothing; of each request the newest. Never waits. The block stays as it is for as long
  // as `memory` is kept, on any thread, after the link's end too.
  struct Image {
    std::shared_ptr<const void> memory;
    std::span<const std::byte> block;
  };
  virtual std::optional<Image> poll_image() { return {}; }

  // Why no renderer is reached, in one sentence for people, as far as the link knows; else empty.
  virtual std::string problem() const { return {}; }

  virtual LinkStats stats() const = 0;
};

// --- the renderer's end
// ----------------------------------------------------------------------------------------------

using PeerId = uint64_t;  // unique within one listener for the life of the process, never reused

struct LinkEvent {
  enum class Kind { connected, pose, control, disconnected, note };
  Kind kind;
  PeerId peer = 0;
  std::span<const std::byte> message;  // pose, control; valid during the callback only
  std::string_view text;    // disconnected: the reason; note: something a person should read (once)
  int64_t received_ns = 0;  // pose, control: monotonic, when the link got it; 0: just now
};

enum class Delivery {
  newest,  // between two polls, at most the newest whole frame of each peer
  all,     // every frame that the medium still has, in order; for lockstep and recording
};

// Thread-safety: one thread polls and sends; stats() may be called from any thread.
class ListenerLink {
 public:
  virtual ~ListenerLink() = default;

  // Calls back for all that has come since the last poll, in order per peer. Never waits.
  virtual void poll(const std::function<void(const LinkEvent&)>& on_event) = 0;

  // Waits until poll() may have something, or the time is over.
  virtual void wait(std::chrono::nanoseconds timeout) = 0;

  // One control message to one peer. Best effort; never waits; a peer that is gone is not an error.
  virtual void send(PeerId peer, std::span<const std::byte> message) = 0;

  virtual bool carries_images() const { return false; }
  // An image to one peer: its encoded ImageFrame, and pixels that `fill` writes where they are sent from.
  // Never waits for the peer: an older image of the request that has not left yet gives way. False: this one
  // is not sent (counted), and `fill` was perhaps not called.
  using FillPixels = std::function<void(std::span<std::byte> pixels)>;
  virtual bool send_image(PeerId, uint64_t /*request*/, std::span<const std::byte> /*head*/,
                          size_t /*pixel_bytes*/, const FillPixels&) {
    return false;
  }

  // The budget that this peer's messages are charged to, from its `connected` event to its `disconnected` event.
  // Null: the link holds nothing for the peer, and the caller makes a budget of its own.
  virtual std::shared_ptr<PeerBudget> budget(PeerId) const { return nullptr; }

  // The stream of this peer has been described and accepted. A listener whose places are all taken gives the
  // place of a peer that was not accepted to a new one.
  virtual void accept(PeerId) {}

  // While a peer is paused, poll() leaves its messages in the link, where the link's bounds hold: it stops
  // reading, or drops older poses. For receivers that still hold messages of an earlier poll().
  virtual void pause_peer(PeerId, bool /*is_paused*/) {}

  virtual LinkStats stats() const = 0;

  // The URI that a publisher may use to reach this listener (with the port that was chosen for port 0).
  virtual std::string uri() const = 0;
};

}  // namespace fire3dv::transport

// Publisher stream behind the C API: link, description, edits, image requests and replies, and the error of a
// C call. Its functions are called under its lock (call.h); they neither wait nor throw, except for lack of
// memory.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "fire3dv/client.h"
#include "images.h"
#include "inputs.h"
#include "protocol/transport/core/fork_guard.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/edit_store.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::client {

// Per-thread error of a C call: a return code and a message for fire3dv_last_error. Setting it allocates
// nothing.
inline thread_local char last_error_text[1024] = "";

// Stores the message, truncated to the thread's buffer, and returns the code.
inline int fail(int code, std::string_view sentence) noexcept {
  const size_t length = std::min(sentence.size(), sizeof last_error_text - 1);
  std::memcpy(last_error_text, sentence.data(), length);
  last_error_text[length] = '\0';
  return code;
}

inline const char* last_error() noexcept {
  return last_error_text;
}

// Runs the body of a C function and converts exceptions to codes, since none may reach C callers. Only
// resource failures throw here.
template <typename Body>
int guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(FIRE3DV_ERROR_SYSTEM, "out of memory");
  } catch (const std::exception& thrown) {
    return fail(FIRE3DV_ERROR_SYSTEM, thrown.what());
  }
}

// Limits of messages that the library sends; readers refuse anything beyond them.
wire::DecodeLimits outgoing_limits();

// Limits of messages from renderers.
wire::DecodeLimits incoming_limits();

// Reads this machine's monotonic and real-time clocks.
wire::ClockInfo read_clocks();

inline uint64_t monotonic_now_ns() noexcept {
  return static_cast<uint64_t>(monotonic_ns());
}

// Converts the caller's struct to a message with a placeholder epoch. Errors are the caller's
// (FIRE3DV_ERROR_ARGUMENT).
Result<wire::StreamDescription> read_description(const fire3dv_description& description);

// Returns true when the caller's struct has at least known_size bytes and zeros in fields beyond them.
bool struct_is_known(const void* data, size_t struct_size, size_t known_size);

}  // namespace fire3dv::client

struct fire3dv_stream {
  // Of the calls in progress (call.h). Recursive, since functions of robots call those of streams.
  std::recursive_mutex mutex;
  std::atomic<int> calls{0};
  std::atomic<bool> closing{false};
  const unsigned opened_in = fire3dv::transport::fork_generation();
  bool is_inherited() const { return opened_in != fire3dv::transport::fork_generation(); }

  std::unique_ptr<fire3dv::transport::PublisherLink> link;
  std::string uri;
  std::string adapter_name;
  bool takes_input = true;  // false: anyone could forge events

  fire3dv::wire::PoseFrameEncoder encoder;
  uint32_t node_count = 0;
  uint32_t poses_per_part = 0;
  size_t max_pose_message_bytes = 0;
  uint64_t epoch = 0;  // 0: not described yet
  uint64_t sequence = 0;
  uint64_t frames_published = 0;
  int64_t last_sim_time_ns = 0;  // of the frame published last in this epoch

  fire3dv::wire::EditStore edits;
  uint64_t scene_version = 0;  // version of the newest edit handed to the link that delays frames

  struct ScalarGroup {
    uint64_t declaration = 0;  // version of the edit that declared it
    size_t count = 0;
  };
  std::map<std::string, ScalarGroup> scalar_groups;

  fire3dv::client::Images images;
  fire3dv::client::Inputs inputs;

  // Pose cache for partial frames, filled from the first partial frame on.
  bool has_cached_poses = false;
  std::vector<fire3dv::wire::Affine3x4> cached_poses;
  uint64_t whole_at_ns = 0;  // monotonic time of the last whole frame
  std::vector<fire3dv::wire::PoseFrameEncoder> part_encoders;
  std::vector<fire3dv::wire::MessagePieces> whole;

  fire3dv::wire::Decoder decoder{fire3dv::client::incoming_limits()};
  std::vector<std::byte> reply;
  uint64_t acked_sequence = 0;
  int32_t welcome = -1;
  uint32_t unmatched_names = 0;
  uint32_t conflicting_names = 0;
  uint32_t contested_names = 0;
  std::string welcome_message;
  std::string status_message;
  // Of the renderer, about poses and edits, the oldest first. Each is shown by one poll at least.
  std::vector<std::string> advice;

  // Replaces the description and starts a new epoch. On error the old description stays in force.
  void fit_parts_to_link();
  fire3dv::Result<void> describe(fire3dv::wire::StreamDescription description);
  // Sends one frame, split into parts where the link needs them. Neither waits nor allocates after the first
  // frame.
  void publish(int64_t sim_time_ns, uint32_t flags,
               std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  // Sends poses of these nodes, with increasing indices. The first call must name all nodes.
  void publish_some(int64_t sim_time_ns, uint32_t flags, std::span<const uint32_t> node_indices,
                    std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  // On error nothing changes.
  fire3dv::Result<void> send_edit(fire3dv::wire::EditStore::Prepared prepared);
  // Processes a bounded number of replies, so that a flood of them cannot stall the simulator.
  void read_replies();
  // Last status of renderers, one line.
  std::string status_text() const;
  // What is known of the renderers when a wait for them ends without a result, one clause.
  std::string reach_text() const;

 private:
  fire3dv::Result<void> resend_edits();
  void cache_poses(std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  void on(const fire3dv::wire::Welcome& answer);
  void on(const fire3dv::wire::Ack& ack);
  void on(const fire3dv::wire::Ping& ping);
  void on(const fire3dv::wire::Status& status);
};

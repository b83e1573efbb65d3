// One stream of a simulator: what the C functions share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "fire3dv/client.h"
#include "protocol/error.h"
#include "images.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/edit_store.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::client {

// What the library refuses to send, since every reader would refuse it.
wire::DecodeLimits outgoing_limits();

// What a renderer may send us.
wire::DecodeLimits incoming_limits();

// This machine's clocks now.
wire::ClockInfo read_clocks();
uint64_t monotonic_now_ns() noexcept;

// The caller's struct as a message; the error is the caller's (FIRE3DV_ERROR_ARGUMENT). epoch is left 0.
Result<wire::StreamDescription> read_description(const fire3dv_description& description);

// True when a struct that the caller filled is one that this library understands: at least as long as the
// first version of it, and nothing set in fields that this version does not know.
bool struct_is_known(const void* data, size_t struct_size, size_t known_size);

}  // namespace fire3dv::client

struct fire3dv_stream {
  std::unique_ptr<fire3dv::transport::PublisherLink> link;
  std::string adapter_name;

  fire3dv::wire::PoseFrameEncoder encoder;
  uint32_t node_count = 0;
  uint32_t poses_per_part = 0;
  size_t max_pose_message_bytes = 0;
  uint64_t epoch = 0;  // 0: not described yet
  uint64_t sequence = 0;
  uint64_t frames_published = 0;

  fire3dv::wire::EditStore edits;
  uint64_t scene_version = 0;  // of the newest edit that the link has taken

  fire3dv::client::Images images;

  // For partial frames, from the first of them on.
  bool keeps_poses = false;
  std::vector<fire3dv::wire::Affine3x4> kept_poses;
  uint64_t whole_at_ns = 0;  // when the last whole frame was published
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

  // Replaces what is described. On error the earlier description stays in force.
  fire3dv::Result<void> describe(fire3dv::wire::StreamDescription description);
  // Sends one frame, in parts where the link needs them. Neither waits nor allocates after the first frame.
  void publish(int64_t sim_time_ns, uint32_t flags,
               std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  // A frame that moves these nodes alone, in rising order. Nodes are all named the first time.
  void publish_some(int64_t sim_time_ns, uint32_t flags, std::span<const uint32_t> node_indices,
                    std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  // On error nothing has changed.
  fire3dv::Result<void> send_edit(fire3dv::wire::EditStore::Prepared prepared);
  // Takes in what renderers have sent, up to a bound, so that a flood of replies cannot hold the simulator.
  void read_replies();
  // What renderers last said, one line.
  std::string answer_for_people() const;

 private:
  fire3dv::Result<void> send_edits_again();
  void keep_poses(std::span<const fire3dv::wire::Affine3x4> stream_from_body);
  void on(const fire3dv::wire::Welcome& answer);
  void on(const fire3dv::wire::Ack& ack);
  void on(const fire3dv::wire::Ping& ping);
  void on(const fire3dv::wire::Status& status);
};

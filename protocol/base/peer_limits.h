// Resource limits of one peer, and the shares that all peers together may use. docs/design/budgets.md says
// how they work together; the defaults stand in protocol/SPEC.md, section 14.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv {

// Memory and objects that a peer makes a reader hold. A peer is one connection, datagram session or
// shared-memory segment.
enum class Resource : uint8_t {
  received_bytes,     // messages that are not whole, or not read by the renderer yet
  queued_bytes,       // replies and images that wait to be sent to the peer
  description_bytes,  // the stream's description: names, offsets
  names,              // node names of that description
  pose_bytes,         // pose frames: shown, waiting, in assembly
  edits,              // scene edits in force, one per key
  edit_bytes,         // values of those edits
  nodes,              // nodes added to the scene, those of assets included
  lights,             // lights set by edits or brought by assets
  shadow_lights,      // those of them that cast shadows; lights beyond the limit cast none
  asset_bytes,        // decoded assets in host memory
  gpu_bytes,          // estimate of the device memory that added assets and vertices take
  requests,           // open image requests
  request_bytes,      // pixels of one image of each open request
};
constexpr size_t kResourceCount = 14;

struct ResourceInfo {
  Resource resource;
  std::string_view name;  // of options, metrics and panels: "asset-bytes"
  std::string_view noun;  // of sentences: "decoded assets"
  bool is_bytes;          // counts bytes; else objects
  uint64_t per_peer;      // default limit of one peer
  uint64_t reserved;      // default amount that a peer may always use, whatever the others use
  uint64_t shared;        // default sum over all peers of what they use beyond their reserved amounts
};
const std::array<ResourceInfo, kResourceCount>& resource_table();
inline const ResourceInfo& info(Resource resource) {
  return resource_table()[static_cast<size_t>(resource)];
}

// Time that one peer may take of a thread that serves all peers before the others have their turn.
struct TimeSlices {
  int64_t receive_ns = 2'000'000;  // render thread, messages of one peer per poll
  int64_t image_ns = 50'000'000;   // render thread, images for peers between two polls
};

struct PeerLimits {
  PeerLimits();  // the defaults of resource_table()

  std::array<uint64_t, kResourceCount> per_peer, reserved, shared;
  TimeSlices slices;

  uint64_t& of(Resource resource) { return per_peer[static_cast<size_t>(resource)]; }
  uint64_t of(Resource resource) const { return per_peer[static_cast<size_t>(resource)]; }
};

// Sets one limit from "NAME=VALUE". NAME is a ResourceInfo::name (limit of one peer), "shared-" and such a
// name (sum of all peers beyond their reserved amounts), "receive-ms" or "image-ms". VALUE is a whole number,
// for bytes with an optional suffix KiB, MiB or GiB. The error names what is wrong and lists the names.
Result<void> set_limit(std::string_view text, PeerLimits& limits);

// "84 KiB", "12 MiB", "4096": an amount as sentences and panels show it.
std::string amount_text(Resource resource, uint64_t amount);

}  // namespace fire3dv

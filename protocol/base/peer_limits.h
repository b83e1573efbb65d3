// Resource limits of one peer, and limits on the sum over all peers. Semantics: docs/design/budgets.md;
// defaults: protocol/SPEC.md, section 14.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv {

// Resources that a reader allocates on behalf of a peer. A peer is one connection, datagram session or
// shared-memory segment.
enum class Resource : uint8_t {
  received_bytes,     // incomplete messages, and messages that the renderer has not read yet
  queued_bytes,       // replies and images queued for sending to the peer
  description_bytes,  // stream description: names, offsets
  names,              // node names in the description
  pose_bytes,         // pose frames: displayed, queued, in assembly
  edits,              // active scene edits, one per key
  edit_bytes,         // values of active edits
  nodes,              // nodes added to the scene, including those of assets
  lights,             // lights set by edits or contained in assets
  shadow_lights,      // shadow-casting subset of `lights`; lights beyond the limit cast no shadow
  asset_bytes,        // decoded assets in host memory
  gpu_bytes,          // estimated device memory of added assets and vertices
  requests,           // open image requests
  request_bytes,      // pixels of one image per open request
};
constexpr size_t kResourceCount = 14;

struct ResourceInfo {
  Resource resource;
  std::string_view name;  // used in options, metrics and panels: "asset-bytes"
  std::string_view noun;  // used in messages: "decoded assets"
  bool is_bytes;          // unit: bytes; otherwise a count of objects
  uint64_t per_peer;      // default limit of one peer
  uint64_t reserved;      // default amount guaranteed to each peer, regardless of the other peers
  uint64_t shared;        // default limit of the sum over all peers of their use beyond the reserved amounts
};
const std::array<ResourceInfo, kResourceCount>& resource_table();
inline const ResourceInfo& info(Resource resource) {
  return resource_table()[static_cast<size_t>(resource)];
}

// Time slices of the render thread: the longest time for one peer before the other peers get their turn.
struct TimeSlices {
  int64_t receive_ns = 2'000'000;  // messages of one peer per poll
  int64_t image_ns = 50'000'000;   // image requests between two polls
};

struct PeerLimits {
  PeerLimits();  // the defaults of resource_table()

  std::array<uint64_t, kResourceCount> per_peer, reserved, shared;
  TimeSlices slices;

  uint64_t& of(Resource resource) { return per_peer[static_cast<size_t>(resource)]; }
  uint64_t of(Resource resource) const { return per_peer[static_cast<size_t>(resource)]; }
};

// Sets one limit from "NAME=VALUE". NAME is a ResourceInfo::name (limit of one peer), "shared-" and such a
// name (sum over all peers beyond their reserved amounts), "receive-ms" or "image-ms". VALUE is an integer;
// byte limits accept the suffixes KiB, MiB and GiB. The error describes the fault and lists the names.
Result<void> set_limit(std::string_view text, PeerLimits& limits);

// Formats an amount for messages and panels: "84 KiB", "12 MiB", "4096".
std::string amount_text(Resource resource, uint64_t amount);

}  // namespace fire3dv

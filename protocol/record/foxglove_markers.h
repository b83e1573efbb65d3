// Conversion of one stream's markers to Foxglove's scene entities and point clouds. protocol/SPEC-record.md
// has the mapping and its losses. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/wire/affine.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/marker.h"
#include "protocol/wire/messages.h"

namespace fire3dv::record {

constexpr std::string_view kPointCloudSchema = "foxglove.PointCloud";
// Of one message, since viewers accept chunks of at most 16 MiB by default.
constexpr uint64_t kMaxMarkerBytes = uint64_t{12} << 20;

struct FoxgloveMessage {
  std::string cloud;  // name of the marker whose PointCloud it is; empty: a SceneUpdate
  wire::Bytes data;
};

class FoxgloveMarkers {
 public:
  // Of a new run of the stream, which has no markers yet.
  void describe(const wire::StreamDescription& description);

  // Messages that replace the marker of this name. time_ns: log time.
  std::vector<FoxgloveMessage> set(const std::string& name, const wire::Marker& marker, uint64_t time_ns);
  std::vector<FoxgloveMessage> clear(const std::string& name, uint64_t time_ns);
  std::vector<FoxgloveMessage> clear_all(uint64_t time_ns);
  // Deletes the markers whose lifetime ends before this simulator time, that of the newest frame.
  std::vector<FoxgloveMessage> advance(int64_t sim_time_ns, uint64_t time_ns);

  // Values that were not converted: images, longer than kMaxMarkerBytes, or too many.
  uint64_t left_out() const { return left_out_; }
  void count_left_out() { ++left_out_; }

 private:
  struct Shown {
    bool is_cloud = false;
    std::optional<int64_t> end_ns;  // last simulator time that shows it
  };
  // Frame of the entity, and the marker's frame in it.
  struct EntityFrame {
    std::string frame_id;
    wire::Affine3x4d frame_from_marker;
  };
  EntityFrame entity_frame(const wire::Marker& marker) const;
  void forget(std::map<std::string, Shown>::iterator entry);

  std::vector<std::string> frame_ids_;  // by node
  std::map<std::string, size_t, std::less<>> nodes_;
  std::vector<wire::Affine3x4> body_from_node_;
  wire::Affine3x4d root_from_stream_;
  double stream_scale_ = 1;
  int64_t sim_time_ns_ = INT64_MIN;
  std::map<std::string, Shown> shown_;
  size_t name_bytes_ = 0;  // of shown_
  std::set<std::pair<int64_t, std::string>> ends_;
  uint64_t left_out_ = 0;
};

// Frame of each node: its name, or a substitute where viewers would refuse that.
std::vector<std::string> foxglove_frame_ids(const wire::StreamDescription& description);

}  // namespace fire3dv::record

// Foxglove messages of recorded streams: transforms and markers, each on a channel of its own. It observes
// what StreamLog records. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/record/file_channels.h"
#include "protocol/record/foxglove.h"
#include "protocol/record/foxglove_markers.h"
#include "protocol/wire/messages.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::record {

class FoxgloveLog {
 public:
  // The current file, for one call.
  struct Output {
    FileChannels& channels;
    uint64_t log_time_ns = 0;
    std::function<Result<void>(uint16_t channel, uint32_t sequence, uint64_t publish_time_ns,
                               std::span<const std::byte> message)>
        write;
  };
  // Conversion of one stream.
  struct Stream {
    FoxgloveTransforms transforms;
    FoxgloveMarkers markers;
    uint16_t transforms_channel = 0, markers_channel = 0;  // in the current file; 0: not yet
  };

  // Call for each new file, with all streams' channels set to 0.
  void begin_file() { cloud_channels_ = 0; }
  // publish_time_ns: Unix time of the frame. name: the stream's, here and below.
  Result<void> write_transforms(const Output& output, Stream& stream, const std::string& name,
                                const wire::PoseFrameView& frame, uint64_t publish_time_ns);
  Result<void> write_marker(const Output& output, Stream& stream, const std::string& name,
                            const wire::SceneEdit& edit);
  // Messages of stream.markers.
  Result<void> write_markers(const Output& output, Stream& stream, const std::string& name,
                             const std::vector<FoxgloveMessage>& messages);

 private:
  Result<std::optional<uint16_t>> cloud_channel(FileChannels& channels, const std::string& name,
                                                const std::string& marker);

  size_t cloud_channels_ = 0;  // of point clouds in the current file
};

}  // namespace fire3dv::record

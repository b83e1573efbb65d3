// A stream's motion, and scenes, as messages of Foxglove's schemas: for viewers that do not know ours. What
// is lost on the way (scale and shear, edits, shapes of bodies) is told in protocol/SPEC-record.md.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::record {

constexpr std::string_view kTransformsSchema = "foxglove.FrameTransforms";
constexpr std::string_view kSceneUpdateSchema = "foxglove.SceneUpdate";
// The frame that all others stand in: the scene's world turned so that Z is up, in metres. Viewers show a
// glTF model turned like that, and frames as they are told.
constexpr std::string_view kRootFrame = "world";

// A scene that can be shown without its file.
struct FoxgloveModel {
  std::string name, media_type;
  wire::Bytes data;
};
// Readers take chunks of 16 MiB by themselves, and a message is never cut.
constexpr uint64_t kMostModelBytes = uint64_t{12} << 20;

wire::Bytes scene_update(std::span<const FoxgloveModel> models, uint64_t time_ns);

// The transforms of one stream.
class FoxgloveTransforms {
 public:
  FoxgloveTransforms();
  ~FoxgloveTransforms();
  FoxgloveTransforms(FoxgloveTransforms&&) noexcept;
  FoxgloveTransforms& operator=(FoxgloveTransforms&&) noexcept;

  void describe(const wire::StreamDescription& description);
  // A FrameTransforms message of the nodes that this message moves: of all, or of those of a part or a
  // partial frame. Valid until the next call; empty for a frame that does not fit the description.
  std::span<const std::byte> encode(const wire::PoseFrameView& frame, uint64_t time_ns);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::record

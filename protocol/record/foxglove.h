// Conversion of pose frames and models to Foxglove schemas, for viewers without support for our schema.
// protocol/SPEC-record.md lists the losses: scale and shear, edits other than markers, shapes of bodies.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "protocol/wire/affine.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::record {

constexpr std::string_view kTransformsSchema = "foxglove.FrameTransforms";
constexpr std::string_view kSceneUpdateSchema = "foxglove.SceneUpdate";
// Root coordinate frame: the scene's world rotated to Z up, in metres. Viewers rotate glTF models in the same
// way.
constexpr std::string_view kRootFrame = "world";

// Model embedded in the recording, so that viewers need no file.
struct FoxgloveModel {
  std::string name, media_type;
  wire::Bytes data;
};
// Viewers accept chunks of at most 16 MiB by default, and a message is never split.
constexpr uint64_t kMaxModelBytes = uint64_t{12} << 20;

wire::Bytes scene_update(std::span<const FoxgloveModel> models, uint64_t time_ns);

// Encoder of one stream's transforms.
class FoxgloveTransforms {
 public:
  FoxgloveTransforms();
  ~FoxgloveTransforms();
  FoxgloveTransforms(FoxgloveTransforms&&) noexcept;
  FoxgloveTransforms& operator=(FoxgloveTransforms&&) noexcept;

  void describe(const wire::StreamDescription& description);
  // Encodes a FrameTransforms message of all nodes in `frame`, which may be a part or a partial frame. Valid
  // until the next call; empty for a frame that does not match the description.
  std::span<const std::byte> encode(const wire::PoseFrameView& frame, uint64_t time_ns);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Rigid part (rotation and translation) of an affine transform, since Foxglove transforms have no scale.
struct RigidPart {
  std::array<double, 4> rotation_xyzw{0, 0, 0, 1};  // unit length
  std::array<double, 3> translation{};
};

// Nearest rotation to the 3x3 part (least squares over its elements). For a rotation with uniform scale it is
// that rotation up to rounding. Reflections and singular matrices also have a nearest rotation, which may not
// be unique; the zero matrix yields the identity.
RigidPart rigid_part(const wire::Affine3x4d& map);

wire::Affine3x4d product(const wire::Affine3x4d& a, const wire::Affine3x4& b);

}  // namespace fire3dv::record

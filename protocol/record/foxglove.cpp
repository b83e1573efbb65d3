#include "protocol/record/foxglove.h"

#include <algorithm>

#include "frame_transforms_generated.h"
#include "protocol/record/rigid_part.h"
#include "scene_update_generated.h"

namespace fire3dv::record {
namespace {

foxglove::Time time_of(uint64_t unix_ns) {
  return {static_cast<uint32_t>(std::min<uint64_t>(unix_ns / 1'000'000'000, UINT32_MAX)),
          static_cast<uint32_t>(unix_ns % 1'000'000'000)};
}

// Writes defaults explicitly: the defaults differ between versions of the schemas.
flatbuffers::FlatBufferBuilder builder_that_writes_all(size_t bytes) {
  flatbuffers::FlatBufferBuilder builder(bytes);
  builder.ForceDefaults(true);
  return builder;
}

std::span<const std::byte> bytes_of(const flatbuffers::FlatBufferBuilder& builder) {
  return std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
}

// Rotates a transform by 90 degrees about X: from Y up to Z up.
wire::Affine3x4d z_up_from(const wire::Affine3x4d& y_up_from_stream) {
  const auto& m = y_up_from_stream.m;
  return {{m[0], m[1], m[2], m[3], -m[8], -m[9], -m[10], -m[11], m[4], m[5], m[6], m[7]}};
}

}  // namespace

wire::Bytes scene_update(std::span<const FoxgloveModel> models, uint64_t time_ns) {
  flatbuffers::FlatBufferBuilder builder = builder_that_writes_all(1024);
  const foxglove::Time time = time_of(time_ns);
  const foxglove::Duration for_ever(0, 0);
  std::vector<flatbuffers::Offset<foxglove::SceneEntity>> entities;
  for (const FoxgloveModel& model : models) {
    const auto data =
        builder.CreateVector(reinterpret_cast<const uint8_t*>(model.data.data()), model.data.size());
    const auto type = builder.CreateString(model.media_type);
    const auto url = builder.CreateString("");
    const auto color = foxglove::CreateColor(builder, 1, 1, 1, 1);
    const auto scale = foxglove::CreateVector3(builder, 1, 1, 1);
    const auto position = foxglove::CreateVector3(builder, 0, 0, 0);
    const auto orientation = foxglove::CreateQuaternion(builder, 0, 0, 0, 1);
    const auto pose = foxglove::CreatePose(builder, position, orientation);
    const auto primitive =
        foxglove::CreateModelPrimitive(builder, pose, scale, color, false, url, type, data);
    const auto primitives = builder.CreateVector(&primitive, 1);
    const auto id = builder.CreateString(model.name);
    const auto frame = builder.CreateSharedString(kRootFrame.data(), kRootFrame.size());
    foxglove::SceneEntityBuilder entity(builder);
    entity.add_timestamp(&time);
    entity.add_frame_id(frame);
    entity.add_id(id);
    entity.add_lifetime(&for_ever);
    entity.add_frame_locked(true);
    entity.add_models(primitives);
    entities.push_back(entity.Finish());
  }
  builder.Finish(foxglove::CreateSceneUpdate(builder, 0, builder.CreateVector(entities)));
  const auto bytes = bytes_of(builder);
  return {bytes.begin(), bytes.end()};
}

struct FoxgloveTransforms::Impl {
  std::vector<std::string> frame_ids;
  wire::Affine3x4d root_from_stream;
  flatbuffers::FlatBufferBuilder builder = builder_that_writes_all(4096);
  std::vector<flatbuffers::Offset<foxglove::FrameTransform>> transforms;

  void add(size_t node, const wire::Affine3x4& stream_from_body, const foxglove::Time& time,
           flatbuffers::Offset<flatbuffers::String> parent) {
    const RigidPart root_from_body = rigid_part(product(root_from_stream, stream_from_body));
    const auto& t = root_from_body.translation;
    const auto& r = root_from_body.rotation_xyzw;
    const auto translation = foxglove::CreateVector3(builder, t[0], t[1], t[2]);
    const auto rotation = foxglove::CreateQuaternion(builder, r[0], r[1], r[2], r[3]);
    const auto child = builder.CreateString(frame_ids[node]);
    transforms.push_back(
        foxglove::CreateFrameTransform(builder, &time, parent, child, translation, rotation));
  }
};

FoxgloveTransforms::FoxgloveTransforms() : impl_(std::make_unique<Impl>()) {}
FoxgloveTransforms::~FoxgloveTransforms() = default;
FoxgloveTransforms::FoxgloveTransforms(FoxgloveTransforms&&) noexcept = default;
FoxgloveTransforms& FoxgloveTransforms::operator=(FoxgloveTransforms&&) noexcept = default;

void FoxgloveTransforms::describe(const wire::StreamDescription& description) {
  impl_->root_from_stream = z_up_from(description.world_from_stream);
  impl_->frame_ids = description.node_names;
  // Viewers reject a frame that is its own parent and a frame without a name.
  for (size_t i = 0; i < impl_->frame_ids.size(); ++i) {
    std::string& id = impl_->frame_ids[i];
    if (id.empty() || id == kRootFrame) id += "/node_" + std::to_string(i);
  }
}

std::span<const std::byte> FoxgloveTransforms::encode(const wire::PoseFrameView& frame, uint64_t time_ns) {
  Impl& impl = *impl_;
  if (frame.node_count != impl.frame_ids.size()) return {};
  impl.builder.Clear();
  impl.transforms.clear();
  const foxglove::Time time = time_of(time_ns);
  const auto parent = impl.builder.CreateString(kRootFrame.data(), kRootFrame.size());
  for (size_t i = 0; i < frame.poses.size(); ++i) {
    const size_t node = frame.node_indices.empty() ? frame.first_node + i : frame.node_indices[i];
    impl.add(node, frame.poses[i], time, parent);
  }
  impl.builder.Finish(
      foxglove::CreateFrameTransforms(impl.builder, impl.builder.CreateVector(impl.transforms)));
  return bytes_of(impl.builder);
}

}  // namespace fire3dv::record

#include "protocol/record/foxglove.h"

#include <algorithm>
#include <cmath>

#include "frame_transforms_generated.h"
#include "protocol/record/foxglove_encoding.h"
#include "protocol/record/foxglove_markers.h"
#include "scene_update_generated.h"

namespace fire3dv::record {

namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

// Eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi rotations. They always converge; for
// 4x4 a few sweeps reach full precision.
std::array<double, 4> principal_vector(Matrix4 a) {
  constexpr int kSweeps = 12;
  Matrix4 vectors{};
  for (size_t i = 0; i < 4; ++i) vectors[i][i] = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double off = 0, on = 0;
    for (size_t i = 0; i < 4; ++i)
      for (size_t j = 0; j < 4; ++j) (i == j ? on : off) += a[i][j] * a[i][j];
    if (off <= 1e-34 * on || off == 0) break;
    for (size_t p = 0; p < 3; ++p) {
      for (size_t q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (size_t k = 0; k < 4; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (size_t k = 0; k < 4; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
          const double vp = vectors[k][p], vq = vectors[k][q];
          vectors[k][p] = c * vp - s * vq;
          vectors[k][q] = s * vp + c * vq;
        }
      }
    }
  }
  size_t best = 0;
  for (size_t i = 1; i < 4; ++i)
    if (a[i][i] > a[best][best]) best = i;
  return {vectors[0][best], vectors[1][best], vectors[2][best], vectors[3][best]};
}

}  // namespace

RigidPart rigid_part(const wire::Affine3x4d& map) {
  RigidPart result;
  const auto& m = map.m;
  result.translation = {m[3], m[7], m[11]};
  double largest = 0;
  for (const size_t i : {0, 1, 2, 4, 5, 6, 8, 9, 10}) largest = std::max(largest, std::abs(m[i]));
  if (largest == 0 || !std::isfinite(largest)) return result;
  const auto e = [&](size_t row, size_t column) { return m[row * 4 + column] / largest; };
  const double xx = e(0, 0), yy = e(1, 1), zz = e(2, 2);
  const double x = e(2, 1) - e(1, 2), y = e(0, 2) - e(2, 0), z = e(1, 0) - e(0, 1);
  const double xy = e(0, 1) + e(1, 0), xz = e(0, 2) + e(2, 0), yz = e(1, 2) + e(2, 1);
  // The unit quaternion q that maximises q^T K q (Horn's solution of the nearest rotation).
  std::array<double, 4> q = principal_vector({{{xx - yy - zz, xy, xz, x},
                                               {xy, yy - xx - zz, yz, y},
                                               {xz, yz, zz - xx - yy, z},
                                               {x, y, z, xx + yy + zz}}});
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double sign = q[3] < 0 ? -1 : 1;  // canonical sign of q and -q: repeated values compress better
  for (size_t i = 0; i < 4; ++i) result.rotation_xyzw[i] = q[i] * sign / length;
  return result;
}

wire::Affine3x4d product(const wire::Affine3x4d& a, const wire::Affine3x4& b) {
  wire::Affine3x4d result;
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? a.m[row * 4 + 3] : 0;
      for (size_t k = 0; k < 3; ++k) sum += a.m[row * 4 + k] * static_cast<double>(b.m[k * 4 + column]);
      result.m[row * 4 + column] = sum;
    }
  return result;
}

foxglove::Time time_of(uint64_t unix_ns) {
  return {static_cast<uint32_t>(std::min<uint64_t>(unix_ns / 1'000'000'000, UINT32_MAX)),
          static_cast<uint32_t>(unix_ns % 1'000'000'000)};
}

flatbuffers::FlatBufferBuilder builder_that_writes_all(size_t bytes) {
  flatbuffers::FlatBufferBuilder builder(bytes);
  builder.ForceDefaults(true);
  return builder;
}

std::span<const std::byte> bytes_of(const flatbuffers::FlatBufferBuilder& builder) {
  return std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
}

wire::Affine3x4d z_up_from(const wire::Affine3x4d& y_up_from_stream) {
  const auto& m = y_up_from_stream.m;
  return {{m[0], m[1], m[2], m[3], -m[8], -m[9], -m[10], -m[11], m[4], m[5], m[6], m[7]}};
}

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
  impl_->frame_ids = foxglove_frame_ids(description);
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

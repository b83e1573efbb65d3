// C entry point of batch.h. It checks arguments and converts them to a wire::ImageRequest.
#include "fire3dv/batch.h"

#include <cstring>
#include <numeric>
#include <string>

#include "call.h"
#include "protocol/wire/check.h"
#include "stream.h"

using fire3dv::Error;
using fire3dv::Result;
using fire3dv::client::fail;
using fire3dv::client::guarded;
namespace wire = fire3dv::wire;

namespace {

constexpr float kDefaultBatchNearM = 0.01f;

template <typename Value, typename Number>
std::vector<Value> copied(const Number* numbers, size_t count) {
  std::vector<Value> values(count);
  if (count > 0) std::memcpy(static_cast<void*>(values.data()), numbers, count * sizeof(Value));
  return values;
}

// Leading dimension of an array: 1, or the number of worlds or views.
Result<void> check_leading(const char* array, const char* field, uint32_t leading, uint32_t count) {
  if (leading == 1 || leading == count) return {};
  return Error{std::string(field) + " is " + std::to_string(leading) + "; the leading dimension of " + array +
               " is 1 (shared) or " + std::to_string(count)};
}

// Checks what must hold before arrays are read.
Result<void> check_sizes(const fire3dv_batch_request& given, uint32_t node_count) {
  if (given.worlds == 0 || given.worlds > wire::kMaxBatchWorlds)
    return Error{"worlds is " + std::to_string(given.worlds) + "; 1 to " +
                 std::to_string(wire::kMaxBatchWorlds) + " are allowed"};
  if (!given.poses) return Error{"poses is NULL"};
  if (auto good = check_leading("poses", "pose_worlds", given.pose_worlds, given.worlds); !good) return good;
  if (!given.node_indices && given.node_count != 0)
    return Error{"node_indices is NULL but node_count is " + std::to_string(given.node_count)};
  if (given.node_indices && (given.node_count == 0 || given.node_count > node_count))
    return Error{"node_count is " + std::to_string(given.node_count) + "; the stream describes " +
                 std::to_string(node_count) + " nodes"};
  for (uint32_t i = 0; i < given.node_count; ++i) {
    if (given.node_indices[i] >= node_count)
      return Error{"node_indices[" + std::to_string(i) + "] is " + std::to_string(given.node_indices[i]) +
                   "; the stream describes " + std::to_string(node_count) + " nodes"};
  }
  const uint64_t poses = uint64_t{given.pose_worlds} * (given.node_indices ? given.node_count : node_count);
  if (poses * sizeof(wire::Affine3x4) > wire::kMaxMessageBytes)
    return Error{std::to_string(poses) + " poses are larger than 256 MiB: take fewer worlds or nodes"};
  if (!given.world_of_view && given.views != 0)
    return Error{"world_of_view is NULL but views is " + std::to_string(given.views)};
  if (given.world_of_view && (given.views == 0 || given.views > wire::kMaxBatchViews))
    return Error{"views is " + std::to_string(given.views) + "; 1 to " +
                 std::to_string(wire::kMaxBatchViews) + " are allowed"};
  if (!given.parent_from_camera) {
    if (given.pose_views == 0) return {};
    return Error{"parent_from_camera is NULL but pose_views is " + std::to_string(given.pose_views)};
  }
  const uint32_t views = given.world_of_view ? given.views : given.worlds;
  return check_leading("parent_from_camera", "pose_views", given.pose_views, views);
}

// Precondition: check_sizes().
wire::ImageRequest read_request(const fire3dv_batch_request& given, uint32_t stream_nodes) {
  wire::ImageBatch batch;
  batch.worlds = given.worlds;
  if (given.node_indices) {
    batch.node_indices = copied<uint32_t>(given.node_indices, given.node_count);
  } else {
    batch.node_indices.resize(stream_nodes);
    std::iota(batch.node_indices.begin(), batch.node_indices.end(), 0u);
  }
  batch.poses = copied<wire::Affine3x4>(given.poses, given.pose_worlds * batch.node_indices.size());
  if (given.world_of_view) batch.world_of_view = copied<uint32_t>(given.world_of_view, given.views);
  const uint32_t views = batch.views();
  if (given.projections) batch.view_projections = copied<wire::Projection>(given.projections, views);
  if (given.active) batch.active = copied<uint8_t>(given.active, given.worlds);

  wire::ImageRequest request;
  request.epoch = request.id = 1;  // placeholders that pass the check; the stream sets both
  request.when = wire::ImageWhen::batch;
  if (given.node) {
    const size_t most = fire3dv::client::outgoing_limits().max_name_bytes;
    request.node.assign(given.node, strnlen(given.node, most + 1));
  }
  if (given.parent_from_camera) {
    std::memcpy(request.parent_from_camera.m.data(), given.parent_from_camera, sizeof(wire::Affine3x4));
    if (given.pose_views > 1) batch.view_poses = copied<wire::Affine3x4>(given.parent_from_camera, views);
  }
  wire::Intrinsics& camera = request.intrinsics;
  camera = {given.width, given.height, given.fx, given.fy, given.cx, given.cy, given.near_m, given.far_m, {}};
  if (given.projections && camera.fx == 0 && camera.fy == 0) {
    const wire::Projection& first = batch.view_projections[0];
    camera.fx = first.fx;
    camera.fy = first.fy;
    camera.cx = first.cx;
    camera.cy = first.cy;
  }
  if (camera.near_m == 0 && (camera.fx != 0 || camera.fy != 0)) camera.near_m = kDefaultBatchNearM;
  request.outputs = given.outputs == 0 ? uint32_t{wire::kColorSrgb8} : given.outputs;
  request.batch = std::move(batch);
  return request;
}

int request_batch(fire3dv_stream* stream, const fire3dv_batch_request* given, uint64_t* id) {
  if (!given || !id) return fail(FIRE3DV_ERROR_ARGUMENT, "request or id is NULL");
  if (!fire3dv::client::struct_is_known(given, given->struct_size, sizeof *given))
    return fail(FIRE3DV_ERROR_ARGUMENT, "batch_request.struct_size is " + std::to_string(given->struct_size) +
                                            "; set it to sizeof(fire3dv_batch_request) (" +
                                            std::to_string(sizeof *given) +
                                            " in this version of the library), and leave unknown fields 0");
  if (stream->epoch == 0)
    return fail(FIRE3DV_ERROR_STATE,
                "the stream has no description yet: call fire3dv_describe before fire3dv_request_batch");
  if ((given->outputs & ~wire::kRequestableOutputs) != 0)
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "outputs is " + std::to_string(given->outputs) + "; only FIRE3DV_IMAGE_* bits may be set");
  if (auto good = check_sizes(*given, stream->node_count); !good)
    return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  wire::ImageRequest request = read_request(*given, stream->node_count);
  if (auto good = wire::check(request, fire3dv::client::outgoing_limits()); !good)
    return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  request.epoch = stream->epoch;
  const auto sent = stream->images.request(*stream->link, std::move(request));
  if (!sent) return fail(FIRE3DV_ERROR_SYSTEM, sent.error().message);
  *id = *sent;
  return FIRE3DV_OK;
}

}  // namespace

int fire3dv_request_batch(fire3dv_stream* stream, const fire3dv_batch_request* request, uint64_t* id) {
  return guarded(stream, [&] { return request_batch(stream, request, id); });
}

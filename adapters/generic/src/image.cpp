// C entry points of image.h. They check arguments and convert them to a wire::ImageRequest; fire3dv_stream
// sends it.
#include "fire3dv/image.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#include "call.h"
#include "protocol/wire/check.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::client::StreamCall;
namespace wire = fire3dv::wire;

namespace {

constexpr float kDefaultNearM = 0.01f;

static_assert(FIRE3DV_IMAGE_BOXES3D == static_cast<int>(wire::kBoxes3d));
static_assert(FIRE3DV_IMAGE_OCCLUSION_U32 == static_cast<int>(wire::kOcclusionU32));
static_assert(FIRE3DV_IMAGE_EXACTLY == static_cast<int>(wire::ImageWhen::exactly));
static_assert(FIRE3DV_LENS_FISHEYE == static_cast<int>(wire::LensModel::fisheye));

// Borrowed image. The caller sees only its public base.
struct BorrowedImage : fire3dv_image {
  std::vector<fire3dv_image_plane> planes;
  fire3dv::transport::PublisherLink::Image keep;
};

wire::ImageRequest read_request(const fire3dv_image_request& given, uint64_t newest_sequence) {
  wire::ImageRequest request;
  request.epoch = request.id = 1;  // placeholders that pass the check; the stream sets both
  if (given.node) {
    // One byte above the limit suffices for the check to refuse the name.
    const size_t most = fire3dv::client::outgoing_limits().max_name_bytes;
    request.node.assign(given.node, strnlen(given.node, most + 1));
  }
  if (given.parent_from_camera)
    std::copy_n(given.parent_from_camera, 12, request.parent_from_camera.m.begin());
  wire::Intrinsics& camera = request.intrinsics;
  const bool is_own = given.fx == 0 && given.fy == 0;
  const float near_m = given.near_m == 0 && !is_own ? kDefaultNearM : given.near_m;
  camera = {given.width, given.height, given.fx, given.fy, given.cx, given.cy, near_m, given.far_m, {}};
  camera.lens.model = static_cast<wire::LensModel>(given.lens);
  std::copy_n(given.lens_coefficients, 5, camera.lens.coefficients.begin());
  request.outputs = given.outputs == 0 ? uint32_t{wire::kColorSrgb8} : given.outputs;
  request.when = given.when == 0 ? wire::ImageWhen::once : static_cast<wire::ImageWhen>(given.when);
  request.every = given.every == 0 ? 1 : given.every;
  request.rate_hz = given.rate_hz;
  request.sequence = given.sequence == 0 ? newest_sequence : given.sequence;
  request.markers = given.markers != 0;
  request.complete = given.complete != 0;
  camera.f_number = given.f_number;
  camera.focus_distance_m = given.focus_distance_m;
  return request;
}

// Bytes that a program has set; 0: its size is none of this structure. Programs built before fields were
// appended pass smaller sizes, and f_number lies where the structure of 1.6 had padding.
size_t known_bytes(const fire3dv_image_request& given) {
  constexpr size_t kSizeOf15 = offsetof(fire3dv_image_request, markers);
  constexpr size_t kSizeOf16 = kSizeOf15 + 8;
  static_assert(offsetof(fire3dv_image_request, f_number) == kSizeOf15 + 4);
  constexpr size_t kSizeOf17 = kSizeOf15 + 16;
  static_assert(offsetof(fire3dv_image_request, complete) == kSizeOf17);
  if (given.struct_size == kSizeOf17) return offsetof(fire3dv_image_request, reserved);
  if (given.struct_size == kSizeOf15) return kSizeOf15;
  if (given.struct_size == kSizeOf16) return offsetof(fire3dv_image_request, f_number);
  return fire3dv::client::struct_is_known(&given, given.struct_size, sizeof given) ? sizeof given : 0;
}

int request_image(fire3dv_stream* stream, const fire3dv_image_request* given, uint64_t* id) {
  if (!given || !id) return fail(FIRE3DV_ERROR_ARGUMENT, "request or id is NULL");
  const size_t bytes = known_bytes(*given);
  if (bytes == 0)
    return fail(FIRE3DV_ERROR_ARGUMENT, "image_request.struct_size is " + std::to_string(given->struct_size) +
                                            "; set it to sizeof(fire3dv_image_request) (" +
                                            std::to_string(sizeof *given) +
                                            " in this version of the library), and leave unknown fields 0");
  fire3dv_image_request complete{};
  std::memcpy(&complete, given, bytes);
  given = &complete;
  if (stream->epoch == 0)
    return fail(FIRE3DV_ERROR_STATE,
                "the stream has no description yet: call fire3dv_describe before fire3dv_request_image");
  if (given->when < 0 || given->when > FIRE3DV_IMAGE_EXACTLY)
    return fail(FIRE3DV_ERROR_ARGUMENT, "when is " + std::to_string(given->when) +
                                            "; use FIRE3DV_IMAGE_ONCE, _EVERY_NTH, _RATE or _EXACTLY");
  if (given->lens < 0 || given->lens > FIRE3DV_LENS_FISHEYE)
    return fail(FIRE3DV_ERROR_ARGUMENT, "lens is " + std::to_string(given->lens) + "; use FIRE3DV_LENS_*");
  if ((given->outputs & ~wire::kRequestableOutputs) != 0)
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "outputs is " + std::to_string(given->outputs) + "; only FIRE3DV_IMAGE_* bits may be set");
  if (given->markers != 0 && given->markers != 1)
    return fail(FIRE3DV_ERROR_ARGUMENT, "markers is " + std::to_string(given->markers) + "; use 0 or 1");
  if (given->complete != 0 && given->complete != 1)
    return fail(FIRE3DV_ERROR_ARGUMENT, "complete is " + std::to_string(given->complete) + "; use 0 or 1");
  if (given->when == FIRE3DV_IMAGE_EXACTLY && given->sequence == 0)
    return fail(FIRE3DV_ERROR_ARGUMENT, "sequence is 0; FIRE3DV_IMAGE_EXACTLY needs the frame's");
  wire::ImageRequest request = read_request(*given, stream->sequence);
  if (auto good = wire::check(request, fire3dv::client::outgoing_limits()); !good)
    return fail(FIRE3DV_ERROR_ARGUMENT, good.error().message);
  request.epoch = stream->epoch;
  const auto sent = stream->images.request(*stream->link, std::move(request));
  if (!sent) return fail(FIRE3DV_ERROR_SYSTEM, sent.error().message);
  *id = *sent;
  return FIRE3DV_OK;
}

int cancel_image(fire3dv_stream* stream, uint64_t id) {
  const auto sent = stream->images.cancel(*stream->link, stream->epoch, id);
  return sent ? FIRE3DV_OK : fail(FIRE3DV_ERROR_SYSTEM, sent.error().message);
}

fire3dv_image* make_image(fire3dv::client::Images::Arrived&& arrived) {
  auto held = std::make_unique<BorrowedImage>();
  const wire::ImageFrame& frame = arrived.frame;
  const wire::Intrinsics& camera = frame.intrinsics;
  for (const wire::ImagePlane& plane : frame.planes)
    held->planes.push_back({1u << plane.output_bit, plane.width, plane.height, plane.row_stride,
                            arrived.pixels.data() + plane.offset});
  held->keep = std::move(arrived.keep);
  fire3dv_image& image = *held;
  image.request = frame.request;
  image.epoch = frame.epoch;
  image.sequence = frame.sequence;
  image.sim_time_ns = frame.sim_time_ns;
  image.number = frame.number;
  image.lost = arrived.lost;
  std::copy_n(frame.world_from_camera.m.begin(), 12, image.world_from_camera);
  image.width = camera.width;
  image.height = camera.height;
  image.fx = camera.fx;
  image.fy = camera.fy;
  image.cx = camera.cx;
  image.cy = camera.cy;
  image.near_m = camera.near_m;
  image.far_m = camera.far_m;
  image.lens = static_cast<int32_t>(camera.lens.model);
  std::copy_n(camera.lens.coefficients.begin(), 5, image.lens_coefficients);
  image.f_number = camera.f_number;
  image.focus_distance_m = camera.focus_distance_m;
  image.hidden_streams = frame.hidden_streams;
  image.views = frame.views;
  image.plane_count = held->planes.size();
  image.planes = held->planes.data();
  return held.release();
}

int wait_image(StreamCall& call, fire3dv_stream& stream, uint64_t id, uint32_t timeout_ms,
               fire3dv_image** result) {
  if (!result) return fail(FIRE3DV_ERROR_ARGUMENT, "image is NULL");
  *result = nullptr;
  fire3dv::client::Images& images = stream.images;
  const std::optional<int> code = call.wait(timeout_ms, [&]() -> std::optional<int> {
    images.collect(*stream.link, stream.epoch, stream.sequence, id);
    if (auto arrived = images.take(id)) {
      *result = make_image(std::move(*arrived));
      return int{FIRE3DV_OK};
    }
    stream.read_replies();
    if (auto why = images.take_refusal(id)) return fail(FIRE3DV_ERROR_REFUSED, *why);
    if (id != 0 && !images.is_open(id))
      return fail(FIRE3DV_ERROR_ARGUMENT, "no image of request " + std::to_string(id) + " is to come");
    if (id == 0 && !images.has_open_singles())
      return fail(FIRE3DV_ERROR_STATE, "no image has been requested");
    return {};
  });
  if (code) return *code;
  return fail(FIRE3DV_ERROR_TIMEOUT, "no image came within " + std::to_string(timeout_ms) + " ms; " +
                                         stream.reach_text() +
                                         (images.dropped() == 0 ? "" : "; " + images.dropped_text()));
}

}  // namespace

int fire3dv_request_image(fire3dv_stream* stream, const fire3dv_image_request* request, uint64_t* id) {
  return guarded(stream, [&] { return request_image(stream, request, id); });
}

int fire3dv_cancel_image(fire3dv_stream* stream, uint64_t id) {
  return guarded(stream, [&] { return cancel_image(stream, id); });
}

int fire3dv_wait_image(fire3dv_stream* stream, uint64_t id, uint32_t timeout_ms, fire3dv_image** image) {
  return guarded(stream, [&](StreamCall& call) { return wait_image(call, *stream, id, timeout_ms, image); });
}

void fire3dv_release_image(fire3dv_image** image) {
  if (!image || !*image) return;
  delete static_cast<BorrowedImage*>(*image);
  *image = nullptr;
}

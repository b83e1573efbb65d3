// Golden messages of image requests and image frames (protocol 1.2): valid, of later versions, and invalid.
#include <cmath>

#include "tests/conformance/cases.h"

namespace fire3dv::conformance {
namespace {

using namespace wire;

constexpr uint64_t kImageEpoch = 0x0123456789abcdef;

Intrinsics camera() {
  return {640, 480, 500.5f, 499.5f, 319.5f, 239.25f, 0.05f, 100, {}};
}

ImageRequest request() {
  ImageRequest result;
  result.epoch = kImageEpoch;
  result.id = 0x1122334455667788;
  result.place = 3;
  result.parent_from_camera.m[11] = 2.5f;
  result.intrinsics = camera();
  result.sequence = 9;
  return result;
}

ImageBatch batch() {
  ImageBatch result;
  result.worlds = 2;
  result.node_indices = {4, 1};
  for (uint32_t i = 0; i < 4; ++i) result.poses.emplace_back().m[3] = 0.5f * static_cast<float>(i);
  return result;
}

ImageRequest batch_request(ImageBatch&& of) {
  ImageRequest result = request();
  result.when = ImageWhen::batch;
  result.sequence = 0;
  result.outputs = kColorSrgb8 | kDepthF32;
  result.batch = std::move(of);
  return result;
}

ImageFrame image_case() {
  ImageFrame result;
  result.request = 0x1122334455667788;
  result.number = 4;
  result.epoch = kImageEpoch;
  result.sequence = 12;
  result.sim_time_ns = -5;
  result.world_from_camera.m[3] = 1.5f;
  result.intrinsics = camera();
  result.intrinsics.width = 6;
  result.intrinsics.height = 4;
  result.pixel_bytes = 256;
  result.planes = {{0, ImageFormat::rgba8, 6, 4, 24, 0, 96}, {2, ImageFormat::r32f, 6, 4, 32, 128, 128}};
  return result;
}

}  // namespace

std::vector<Case> image_cases() {
  std::vector<Case> result;
  const auto add = [&](std::string name, Bytes bytes) {
    result.push_back({std::move(name), std::move(bytes), true, {}});
  };
  add("image_request-once", encode(request()));
  ImageRequest r = request();
  r.node = "robot/wrist camera";
  r.intrinsics = {64, 64, 0, 0, 0, 0, 0, 0, {}};
  r.when = ImageWhen::every_nth;
  r.every = 4;
  add("image_request-own_camera_every_4th", encode(r));
  r = request();
  r.intrinsics.lens = {LensModel::plumb_bob, {-0.25f, 0.0625f, 0.001f, -0.002f, 0.01f}};
  r.outputs = 2 * kBoxes3d - 1;  // all of protocol 1.0
  r.when = ImageWhen::rate;
  r.rate_hz = 29.97;
  add("image_request-plumb_bob_all_outputs_rate", encode(r));
  r.intrinsics.lens.model = LensModel::fisheye;
  r.intrinsics.lens.coefficients[4] = 0;
  r.when = ImageWhen::exactly;
  add("image_request-fisheye_exactly", encode(r));
  r = request();
  r.outputs = kAlbedoF16 | kRoughnessF32 | kMetallicF32 | kPositionF32 | kOcclusionU32;
  add("image_request-surfaces", encode(r));
  r = request();
  r.markers = true;
  r.outputs = kColorSrgb8 | kDepthF32;
  add("image_request-with_markers", encode(r));
  r = request();
  r.intrinsics.f_number = 1.8f;
  r.intrinsics.focus_distance_m = 0.75f;
  add("image_request-with_lens", encode(r));
  r = request();
  r.complete = true;
  add("image_request-complete", encode(r));
  add("image_request-batch", encode(batch_request(batch())));
  ImageBatch own_views = batch();
  own_views.poses.resize(2);  // shared
  own_views.world_of_view = {1, 0, 1};
  own_views.view_poses.resize(3);
  own_views.view_poses[2].m[7] = -1.5f;
  own_views.view_projections = {{50, 50, 31.5f, 23.5f}, {60, 61, 31.5f, 23.5f}, {70, 71, 0, -4}};
  own_views.active = {1, 0};
  add("image_request-batch_own_views", encode(batch_request(std::move(own_views))));
  ImageRequest back;
  back.epoch = kImageEpoch;
  back.id = 7;
  back.when = ImageWhen::never;
  add("image_request-taken_back", encode(back));
  r = request();
  r.outputs |= 1u << 20;
  r.when = static_cast<ImageWhen>(9);
  add("image_request-of_later_version", encode(r));  // decodable, so that the renderer can answer it
  add("image_frame-color_and_depth", encode(image_case()));
  ImageFrame blurred = image_case();
  blurred.intrinsics.f_number = 1.8f;
  blurred.intrinsics.focus_distance_m = 0.75f;
  add("image_frame-with_lens", encode(blurred));
  ImageFrame lacking = image_case();
  lacking.hidden_streams = 2;
  add("image_frame-hidden_streams", encode(lacking));
  ImageFrame of_batch = image_case();
  of_batch.views = 3;
  of_batch.planes = {{0, ImageFormat::rgba8, 6, 12, 24, 0, 288}, {2, ImageFormat::r32f, 6, 12, 24, 320, 288}};
  of_batch.pixel_bytes = 640;
  add("image_frame-batch", encode(of_batch));
  ImageFrame boxes = image_case();
  boxes.planes = {{7, ImageFormat::box2d, 3, 1, 96, 0, 96}, {8, ImageFormat::box3d, 0, 1, 0, 128, 0}};
  add("image_frame-boxes", encode(boxes));
  ImageFrame none = image_case();
  none.sequence = 0;
  none.planes.clear();
  none.pixel_bytes = 0;
  ImageFrame surfaces = image_case();
  surfaces.planes = {{12, ImageFormat::rgba32f, 6, 4, 96, 0, 384},
                     {13, ImageFormat::r32u, 6, 4, 24, 384, 96}};
  surfaces.pixel_bytes = 512;
  add("image_frame-position_and_occlusion", encode(surfaces));
  add("image_frame-no_planes", encode(none));
  add("image_refused",
      encode(ImageRefused{kImageEpoch, 7, ImageRefusal::unknown_camera, "no node \"wrist\""}));
  return result;
}

std::vector<Case> refused_image_cases() {
  std::vector<Case> result;
  const auto add_request = [&](std::string name, std::string refused, auto change) {
    ImageRequest bad = request();
    change(bad);
    result.push_back({"refused-image_request_" + std::move(name), encode(bad), false,
                      "ImageRequest." + std::move(refused)});
  };
  add_request("epoch_zero", "epoch", [](ImageRequest& r) { r.epoch = 0; });
  add_request("id_zero", "id", [](ImageRequest& r) { r.id = 0; });
  add_request("place_beyond", "place", [](ImageRequest& r) { r.place = kMaxImageRequests; });
  add_request("node_newline", "node", [](ImageRequest& r) { r.node = "a\nb"; });
  add_request("pose_nan", "parent_from_camera", [](ImageRequest& r) { r.parent_from_camera.m[5] = NAN; });
  add_request("width_zero", "width", [](ImageRequest& r) { r.intrinsics.width = 0; });
  add_request("height_huge", "height", [](ImageRequest& r) { r.intrinsics.height = UINT32_MAX; });
  add_request("no_camera", "fx", [](ImageRequest& r) { r.intrinsics.fx = r.intrinsics.fy = 0; });
  add_request("fx_zero", "fx", [](ImageRequest& r) { r.intrinsics.fx = 0; });
  add_request("fy_nan", "fy", [](ImageRequest& r) { r.intrinsics.fy = NAN; });
  add_request("cx_infinite", "cx", [](ImageRequest& r) { r.intrinsics.cx = INFINITY; });
  add_request("near_zero", "near_m", [](ImageRequest& r) { r.intrinsics.near_m = 0; });
  add_request("far_before_near", "far_m", [](ImageRequest& r) { r.intrinsics.far_m = 0.01f; });
  add_request("lens_nan", "lens_coefficients", [](ImageRequest& r) {
    r.intrinsics.lens = {LensModel::fisheye, {0, NAN, 0, 0, 0}};
  });
  add_request("lens_of_own_camera", "lens", [](ImageRequest& r) {
    r.node = "eye";
    r.intrinsics.fx = r.intrinsics.fy = 0;
    r.intrinsics.lens.model = LensModel::fisheye;
  });
  add_request("lens_without_focus", "focus_distance_m", [](ImageRequest& r) { r.intrinsics.f_number = 2; });
  add_request("lens_f_number_nan", "f_number", [](ImageRequest& r) {
    r.intrinsics.f_number = NAN;
    r.intrinsics.focus_distance_m = 1;
  });
  add_request("outputs_none", "outputs", [](ImageRequest& r) { r.outputs = 0; });
  add_request("markers_without_color", "markers", [](ImageRequest& r) {
    r.markers = true;
    r.outputs = kDepthF32;
  });
  add_request("markers_in_linear_color", "markers", [](ImageRequest& r) {
    r.markers = true;
    r.outputs = kColorSrgb8 | kColorLinearF16;
  });
  add_request("every_zero", "every", [](ImageRequest& r) {
    r.when = ImageWhen::every_nth;
    r.every = 0;
  });
  add_request("rate_zero", "rate_hz", [](ImageRequest& r) { r.when = ImageWhen::rate; });
  add_request("rate_nan", "rate_hz", [](ImageRequest& r) {
    r.when = ImageWhen::rate;
    r.rate_hz = NAN;
  });
  add_request("exactly_none", "sequence", [](ImageRequest& r) {
    r.when = ImageWhen::exactly;
    r.sequence = 0;
  });
  const auto add_batch = [&](std::string name, std::string refused, auto change) {
    ImageBatch bad = batch();
    change(bad);
    result.push_back({"refused-image_request_batch_" + std::move(name), encode(batch_request(std::move(bad))),
                      false, "ImageRequest.batch" + std::move(refused)});
  };
  add_request("batch_missing", "batch", [](ImageRequest& r) { r.when = ImageWhen::batch; });
  add_request("batch_of_once", "batch", [](ImageRequest& r) { r.batch = batch(); });
  add_batch("no_world", ".worlds", [](ImageBatch& b) { b.worlds = 0; });
  add_batch("many_worlds", ".worlds", [](ImageBatch& b) { b.worlds = 65'536; });
  add_batch("no_node", ".node_indices", [](ImageBatch& b) { b.node_indices.clear(); });
  add_batch("node_twice", ".node_indices", [](ImageBatch& b) { b.node_indices = {4, 4}; });
  add_batch("poses_missing", ".poses", [](ImageBatch& b) { b.poses.resize(3); });
  add_batch("pose_nan", ".poses", [](ImageBatch& b) { b.poses[2].m[1] = NAN; });
  add_batch("world_beyond", ".world_of_view", [](ImageBatch& b) { b.world_of_view = {0, 2}; });
  add_batch("view_pose_missing", ".view_poses", [](ImageBatch& b) { b.view_poses.resize(1); });
  add_batch("view_pose_infinite", ".view_poses", [](ImageBatch& b) {
    b.view_poses.resize(2);
    b.view_poses[1].m[0] = INFINITY;
  });
  add_batch("projection_missing", ".view_projections", [](ImageBatch& b) { b.view_projections.resize(1); });
  add_batch("projection_zero", ".view_projections", [](ImageBatch& b) {
    b.view_projections = {{1, 1, 0, 0}, {1, 0, 0, 0}};
  });
  add_batch("active_missing", ".active", [](ImageBatch& b) { b.active = {1}; });
  add_batch("active_two", ".active", [](ImageBatch& b) { b.active = {1, 2}; });
  add_request("batch_projections_of_own_camera", "batch.view_projections", [](ImageRequest& r) {
    ImageBatch b = batch();
    b.view_projections.resize(2, {1, 1, 0, 0});
    r = batch_request(std::move(b));
    r.node = "eye";
    r.intrinsics.fx = r.intrinsics.fy = 0;
  });

  const auto add_frame = [&](std::string name, std::string refused, auto change) {
    ImageFrame bad = image_case();
    change(bad);
    result.push_back(
        {"refused-image_frame_" + std::move(name), encode(bad), false, "ImageFrame." + std::move(refused)});
  };
  add_frame("request_zero", "request", [](ImageFrame& f) { f.request = 0; });
  add_frame("number_zero", "number", [](ImageFrame& f) { f.number = 0; });
  add_frame("epoch_zero", "epoch", [](ImageFrame& f) { f.epoch = 0; });
  add_frame("pose_nan", "world_from_camera", [](ImageFrame& f) { f.world_from_camera.m[0] = NAN; });
  add_frame("fx_zero", "fx", [](ImageFrame& f) { f.intrinsics.fx = 0; });
  add_frame("pixels_huge", "pixel_bytes", [](ImageFrame& f) { f.pixel_bytes = kMaxPixelBytes + 1; });
  add_frame("output_twice", "planes[1].output", [](ImageFrame& f) { f.planes[1] = f.planes[0]; });
  add_frame("format_of_other_output", "planes[1].format",
            [](ImageFrame& f) { f.planes[1].format = ImageFormat::r32u; });
  add_frame("plane_of_other_size", "planes[0]", [](ImageFrame& f) { f.planes[0].width = 5; });
  add_frame("views_many", "views", [](ImageFrame& f) { f.views = 65'537; });
  add_frame("plane_of_one_view", "planes[0]", [](ImageFrame& f) { f.views = 2; });
  add_frame("padded_rows_of_views", "planes[0].row_stride", [](ImageFrame& f) {
    f.views = 2;
    f.planes = {{2, ImageFormat::r32f, 6, 8, 32, 0, 256}};
  });
  add_frame("rows_overlap", "planes[0]", [](ImageFrame& f) {
    f.planes[0].row_stride = 20;
    f.planes[0].bytes = 80;
  });
  add_frame("bytes_beyond_rows", "planes[0]", [](ImageFrame& f) { f.planes[0].bytes = 97; });
  add_frame("offset_odd", "planes[1].offset", [](ImageFrame& f) { f.planes[1].offset = 100; });
  add_frame("plane_outside", "planes[1].offset", [](ImageFrame& f) { f.planes[1].offset = 192; });
  add_frame("offset_wraps", "planes[1].offset", [](ImageFrame& f) { f.planes[1].offset = ~uint64_t{63}; });
  result.push_back({"refused-image_refused_message_escape",
                    encode(ImageRefused{kImageEpoch, 7, ImageRefusal::too_many, "\x1b[2J"}), false,
                    "ImageRefused.message"});
  result.push_back({"refused-image_refused_request_zero",
                    encode(ImageRefused{kImageEpoch, 0, ImageRefusal::too_many, ""}), false,
                    "ImageRefused.request"});
  return result;
}

}  // namespace fire3dv::conformance

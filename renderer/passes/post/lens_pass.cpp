#include "renderer/passes/post/lens_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fire3dv::passes {

namespace {

constexpr double kMaxAngleRad = 1.4;
constexpr double kPixelsForOne = 2;  // resolution of the pinhole image relative to the lens image, along a
                                     // line
constexpr double kMinPixelsForOne = 0.5;

// Radial term without p1 and p2: distorted radius and its derivative.
struct Radial {
  double value, slope;
};
Radial radial(const Lens& lens, double r) {
  const auto& k = lens.coefficients;
  if (lens.model == LensModel::plumb_bob) {
    const double r2 = r * r;
    return {r * (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))),
            1 + r2 * (3 * k[0] + r2 * (5 * k[1] + r2 * 7 * k[4]))};
  }
  if (lens.model == LensModel::fisheye) {
    const double t = std::atan(r), t2 = t * t;
    return {t * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
            (1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])))) / (1 + r * r)};
  }
  return {r, 1};
}

// Jacobian of the distortion, column-major.
glm::dmat2 slope_of(const Lens& lens, const glm::dvec2& point) {
  constexpr double kStep = 1e-6;
  const glm::dvec2 x(kStep, 0), y(0, kStep);
  return {(distort(lens, point + x) - distort(lens, point - x)) / (2 * kStep),
          (distort(lens, point + y) - distort(lens, point - y)) / (2 * kStep)};
}

double radius_before(const Lens& lens, double distorted, double largest) {
  double low = 0, high = largest, r = std::min(distorted, largest);
  for (int i = 0; i < 60; ++i) {
    const Radial at = radial(lens, r);
    (at.value < distorted ? low : high) = r;
    const double next = r - (at.value - distorted) / at.slope;
    const double before = std::exchange(r, next > low && next < high ? next : 0.5 * (low + high));
    if (std::abs(r - before) < 1e-12) break;
  }
  return r;
}

std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted, double largest) {
  if (lens.model == LensModel::none) return distorted;
  const double d = glm::length(distorted);
  glm::dvec2 point(0);
  if (d > 0) point = distorted * (radius_before(lens, d, largest) / d);
  if (lens.model == LensModel::plumb_bob) {
    for (int i = 0; i < 8; ++i) {
      const glm::dvec2 step = glm::inverse(slope_of(lens, point)) * (distort(lens, point) - distorted);
      if (!std::isfinite(step.x + step.y)) return {};
      point -= step;
    }
  }
  const bool found = glm::length(distort(lens, point) - distorted) < 1e-6 * std::max(1.0, d);
  return found && glm::length(point) <= largest ? std::optional(point) : std::nullopt;
}

// Extent of the visible field, and the largest magnification.
struct VisibleArea {
  glm::dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  double max_magnification = 1;
};
void add(VisibleArea& seen, const Lens& lens, const glm::dvec2& point) {
  seen.low = glm::min(seen.low, point);
  seen.high = glm::max(seen.high, point);
  const glm::dmat2 slope = slope_of(lens, point);
  const double larger = std::max(glm::length(slope[0]), glm::length(slope[1]));
  if (std::isfinite(larger)) seen.max_magnification = std::max(seen.max_magnification, larger);
}

VisibleArea visible_area_through(const Intrinsics& intrinsics, const Lens& lens) {
  const double largest = largest_radius(lens);
  const glm::dvec2 focal(intrinsics.fx_px, intrinsics.fy_px),
      principal_point(intrinsics.cx_px, intrinsics.cy_px);
  const glm::dvec2 end = glm::dvec2(intrinsics.image_px) - 0.5;
  constexpr int kSteps = 64;
  VisibleArea seen;
  bool all = true;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      // The border determines the extent; inside, a few points suffice for the magnification.
      const bool at_edge = i % kSteps == 0 || j % kSteps == 0;
      if (!at_edge && (i % 8 != 0 || j % 8 != 0)) continue;
      const glm::dvec2 pixel = glm::mix(glm::dvec2(-0.5), end, glm::dvec2(i, j) / double{kSteps});
      if (const auto point = undistort(lens, (pixel - principal_point) / focal, largest)) {
        add(seen, lens, *point);
      } else {
        all = false;
      }
    }
  }
  // The visible field ends inside the image, between two grid points.
  if (!all) {
    for (int i = 0; i < 4 * kSteps; ++i) {
      const double angle = 2 * M_PI * i / (4 * kSteps);
      const glm::dvec2 rim = largest * glm::dvec2(std::cos(angle), std::sin(angle));
      const glm::dvec2 pixel = focal * distort(lens, rim) + principal_point;
      if (glm::all(glm::greaterThanEqual(pixel, glm::dvec2(-1))) &&
          glm::all(glm::lessThanEqual(pixel, end + 1.0)))
        add(seen, lens, rim);
    }
  }
  return seen;
}

}  // namespace

glm::dvec2 distort(const Lens& lens, const glm::dvec2& point) {
  if (lens.model == LensModel::none) return point;
  const double r = glm::length(point);
  if (r == 0) return point;
  glm::dvec2 result = point * (radial(lens, r).value / r);
  if (lens.model == LensModel::plumb_bob) {
    const double p1 = lens.coefficients[2], p2 = lens.coefficients[3], xy = 2 * point.x * point.y;
    result += glm::dvec2(p1 * xy + p2 * (r * r + 2 * point.x * point.x),
                         p1 * (r * r + 2 * point.y * point.y) + p2 * xy);
  }
  return result;
}

double largest_radius(const Lens& lens) {
  constexpr int kSteps = 4096;
  double r = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = std::tan(kMaxAngleRad * i / kSteps);
    if (!(radial(lens, next).slope > 1e-3)) break;
    r = next;
  }
  return r;
}

std::optional<glm::dvec2> undistort(const Lens& lens, const glm::dvec2& distorted) {
  return undistort(lens, distorted, largest_radius(lens));
}

Result<Intrinsics> pinhole_behind(const Intrinsics& intrinsics, const Lens& lens, uint32_t max_side) {
  const VisibleArea seen = visible_area_through(intrinsics, lens);
  if (!(seen.low.x <= seen.high.x))
    return Error{"the lens shows nothing at all within the image: look at cx, cy and its coefficients"};
  const glm::dvec2 size = seen.high - seen.low;
  const glm::dvec2 focal(intrinsics.fx_px, intrinsics.fy_px);
  const glm::dvec2 wanted = kPixelsForOne * seen.max_magnification * focal * size;  // pixels
  // One more pixel on each side for bilinear filtering.
  const double room = static_cast<double>(max_side) - 4;
  const double share = std::min({1.0, room / std::max(wanted.x, 1.0), room / std::max(wanted.y, 1.0)});
  if (!(kPixelsForOne * share >= kMinPixelsForOne))
    return Error{
        "the lens shows too wide a view: an image of " + std::to_string(max_side) +
        " pixels would not hold it finely enough; ask for a smaller image, or for one that ends sooner"};
  Intrinsics pinhole = intrinsics;
  const glm::dvec2 used = share * kPixelsForOne * seen.max_magnification * focal;
  pinhole.fx_px = static_cast<float>(used.x);
  pinhole.fy_px = static_cast<float>(used.y);
  pinhole.cx_px = static_cast<float>(1 - used.x * seen.low.x);
  pinhole.cy_px = static_cast<float>(1 - used.y * seen.low.y);
  const glm::dvec2 pixels = glm::ceil(used * size) + 3.0;
  if (!(pixels.x <= max_side && pixels.y <= max_side))
    return Error{"the lens has coefficients that no camera has; give them as OpenCV calibrates them"};
  pinhole.image_px = glm::uvec2(pixels);
  if (Result<void> good = check(pinhole); !good) return good.error();
  return pinhole;
}

namespace {

using gpu::Use;
namespace access = gpu::access;

// Address of a plane, or 0.
VkDeviceAddress address_of(VkDeviceAddress first, std::span<const PlaneRange> places, ImageOutput output) {
  for (const PlaneRange& place : places) {
    if (place.output == output) return first + place.offset_bytes;
  }
  return 0;
}

}  // namespace

ImageOutputs pinhole_outputs(ImageOutputs outputs) {
  outputs = with_sources(outputs);
  // Depth is interpolated within one instance.
  if (outputs.has(wire::kDepthF32)) outputs.add(wire::kInstanceU32);
  // Where a point was decides whether the lens showed it.
  if (outputs.has(wire::kOcclusionU32)) outputs.add(wire::kMotion);
  return outputs;
}

LensPass::LensPass(gpu::Device& device)
    : device_(device),
      layout_(gpu::create_pipeline_layout(device, {})),
      pipeline_(
          gpu::create_compute_pipeline(device, layout_.get(), "lens.comp", gpu::Compile::on_first_use)) {}

void LensPass::copy_color(gpu::Recorder& recorder, gpu::Image& color) {
  recorder.pass("lens colors", {Use(color, access::transfer_read), Use(color_, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  VkBufferImageCopy copy{};
                  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
                  copy.imageExtent = {color.extent.width, color.extent.height, 1};
                  vkCmdCopyImageToBuffer(commands, color.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                         color_.get(), 1, &copy);
                });
}

gpu_types::LensWanted LensPass::describe(const Source& source, const Wanted& wanted) const {
  const Intrinsics &camera = wanted.camera, &pinhole = source.pinhole;
  const bool has_color = wanted.outputs.has(wire::kColorSrgb8) && !wanted.has_optics;
  const VkDeviceSize color_bytes = has_color ? VkDeviceSize{4} * camera.image_px.x * camera.image_px.y : 0;
  const auto from = [&](ImageOutput output) {
    return source.planes ? address_of(source.planes->address, source.places, output) : 0;
  };
  const auto to = [&](ImageOutput output) {
    return address_of(result_.address + color_bytes, places_, output);
  };
  gpu_types::LensWanted w{};
  w.color_in = has_color ? color_.address : 0;
  w.color_out = has_color ? result_.address : 0;
  w.light_in = source.light ? source.light->address : 0;
  w.light_out = source.light ? light_.address : 0;
  w.linear_in = from(wire::kColorLinearF16);
  w.linear_out = to(wire::kColorLinearF16);
  w.depth_in = from(wire::kDepthF32);
  w.depth_out = to(wire::kDepthF32);
  w.instance_in = from(wire::kInstanceU32);
  w.instance_out = to(wire::kInstanceU32);
  w.semantic_in = from(wire::kSemanticU32);
  w.semantic_out = to(wire::kSemanticU32);
  w.normal_in = from(wire::kNormal);
  w.normal_out = to(wire::kNormal);
  w.motion_in = from(wire::kMotion);
  w.motion_out = to(wire::kMotion);
  w.albedo_in = from(wire::kAlbedoF16);
  w.albedo_out = to(wire::kAlbedoF16);
  w.roughness_in = from(wire::kRoughnessF32);
  w.roughness_out = to(wire::kRoughnessF32);
  w.metallic_in = from(wire::kMetallicF32);
  w.metallic_out = to(wire::kMetallicF32);
  w.position_in = from(wire::kPositionF32);
  w.position_out = to(wire::kPositionF32);
  w.occlusion_in = from(wire::kOcclusionU32);
  w.occlusion_out = to(wire::kOcclusionU32);
  w.width = camera.image_px.x;
  w.height = camera.image_px.y;
  w.width_in = pinhole.image_px.x;
  w.height_in = pinhole.image_px.y;
  w.focal = {camera.fx_px, camera.fy_px};
  w.principal_point = {camera.cx_px, camera.cy_px};
  w.focal_in = {pinhole.fx_px, pinhole.fy_px};
  w.principal_point_in = {pinhole.cx_px, pinhole.cy_px};
  const auto& k = wanted.lens.coefficients;
  w.coefficients = {k[0], k[1], k[2], k[3]};
  w.last_coefficient = k[4];
  w.largest_radius = static_cast<float>(largest_radius(wanted.lens));
  w.fisheye = wanted.lens.model == LensModel::fisheye ? 1 : 0;
  w.mask_radius = wanted.mask_radius;
  w.mask_cut = wanted.mask_cut;
  return w;
}

void LensPass::make_room(const Intrinsics& pinhole, const Wanted& wanted) {
  const glm::uvec2 size = wanted.camera.image_px, behind = pinhole.image_px;
  places_ = lay_out_planes(with_sources(wanted.outputs), size.x, size.y);
  const bool has_color = wanted.outputs.has(wire::kColorSrgb8);
  result_bytes_ = (has_color && !wanted.has_optics ? uint64_t{4} * size.x * size.y : 0) + bytes_of(places_);
  gpu::grow_storage_buffer(device_, result_, result_bytes_);
  if (has_color && wanted.has_optics)
    gpu::grow_storage_buffer(device_, light_, VkDeviceSize{8} * size.x * size.y);
  else if (has_color)
    gpu::grow_storage_buffer(device_, color_, VkDeviceSize{4} * behind.x * behind.y);
}

void LensPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                      const Wanted& wanted) {
  const glm::uvec2 size = wanted.camera.image_px;
  make_room(source.pinhole, wanted);
  if (source.color) copy_color(recorder, *source.color);
  const gpu_types::LensWanted described = describe(source, wanted);
  const gpu_types::LensPush push{
      staging.write(std::span<const gpu_types::LensWanted>(&described, 1)).address};
  std::vector<Use> uses{Use(result_, access::compute_write)};
  if (source.color) uses.emplace_back(color_, access::compute_read);
  if (source.planes) uses.emplace_back(*source.planes, access::compute_read);
  if (source.light) {
    uses.emplace_back(*source.light, access::compute_read);
    uses.emplace_back(light_, access::compute_write);
  }
  recorder.pass("lens", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (size.x + 7) / 8, (size.y + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes

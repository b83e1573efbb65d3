#include "renderer/offline/flow_images.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "base/plural.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/passes/outputs/flow_pass.h"

namespace fire3dv::offline {
namespace {

// Of an image that has no other one to be compared with.
sinks::Flow no_flow(size_t pixels) {
  return {std::vector<float>(2 * pixels, std::numeric_limits<float>::quiet_NaN()),
          std::vector<uint8_t>(pixels, sinks::Flow::kOutside)};
}

// motion: two floats a pixel; occlusion: one uint32 a pixel.
sinks::Flow read_flow(std::span<const uint8_t> motion, std::span<const uint8_t> occlusion) {
  sinks::Flow flow;
  flow.motion_px.resize(motion.size() / sizeof(float));
  std::memcpy(flow.motion_px.data(), motion.data(), motion.size());
  std::vector<uint32_t> values(occlusion.size() / sizeof(uint32_t));
  std::memcpy(values.data(), occlusion.data(), occlusion.size());
  flow.occlusion.reserve(values.size());
  for (const uint32_t value : values) flow.occlusion.push_back(static_cast<uint8_t>(value));
  return flow;
}

// Removes a plane from the image.
std::vector<uint8_t> take_plane(sinks::FrameImage& image, wire::ImageOutput output) {
  const auto at = std::ranges::find(image.planes, output, &sinks::FramePlane::output);
  FIRE3DV_ASSERT(at != image.planes.end());
  std::vector<uint8_t> bytes = std::move(at->bytes);
  image.planes.erase(at);
  return bytes;
}

constexpr uint64_t kMaxWaitingBytes = uint64_t{4} << 30;  // of images that wait for their flow

std::string describe(const FlowPlan& plan) {
  return "--flow-frames: flow to images " + counted(plan.frames, "frame") + " apart, of " +
         counted(plan.cameras, "camera") + ",";
}

Error too_large(const std::string& what, uint64_t bytes, uint64_t limit) {
  return Error{what + std::to_string(bytes >> 20) + " MiB; at most " + std::to_string(limit >> 20) +
               ": choose a smaller --size, fewer cameras or fewer frames"};
}

// Without silhouettes, whose number an image decides.
uint64_t image_bytes(const FlowPlan& plan) {
  constexpr uint64_t kFlowBytes = 2 * (2 * sizeof(float) + 1);  // to both sides
  const auto [width, height] = plan.extent;
  return kFlowBytes * width * height +
         wire::pixel_bytes_of(width, height, plan.outputs.bits() & ~uint32_t{wire::kAmodal}, 0);
}

}  // namespace

FlowPlan plan_flow(const ImageSet* set, uint64_t cameras, VkExtent2D extent) {
  if (!set) return {};
  return {set->flow_frames(),       cameras,        set->has_flow_forward(),
          set->has_motion_planes(), set->outputs(), extent};
}

Result<void> check_flow_memory(const FlowPlan& plan, uint64_t snapshot_bytes) {
  if (plan.frames == 0) return {};
  const uint64_t images = plan.stride() + 1;
  const auto [width, height] = plan.extent;
  const uint64_t surfaces_bytes = plan.has_later ? passes::surfaces_bytes(plan.extent) : 0;
  for (const auto& [kind, bytes] :
       {std::pair("surfaces", surfaces_bytes), std::pair("depths", sizeof(float) * uint64_t{width} * height),
        std::pair("poses of nodes and vertices", snapshot_bytes)}) {
    if (images > passes::kMinHistories && images * bytes > passes::kMaxHistoryBytes)
      return too_large(describe(plan) + " keeps " + kind + " on the device that take ", images * bytes,
                       passes::kMaxHistoryBytes);
  }
  const uint64_t waiting_bytes = images * image_bytes(plan);
  if (plan.has_later && waiting_bytes > kMaxWaitingBytes)
    return too_large(describe(plan) + " keeps images in memory that take ", waiting_bytes, kMaxWaitingBytes);
  return {};
}

bool FlowImages::is_needed(uint64_t image, const std::function<bool(uint64_t image)>& is_wanted) const {
  return is_wanted(image) || is_wanted(image + stride_) ||
         (has_later_ && image >= stride_ && is_wanted(image - stride_));
}

std::shared_ptr<const passes::CameraHistory> FlowImages::earlier(uint64_t image, uint64_t scene) const {
  if (image < stride_) return nullptr;
  const auto found = drawn_.find(image - stride_);
  return found != drawn_.end() && found->second.scene == scene ? found->second.history : nullptr;
}

void FlowImages::recorded(gpu::Recorder& recorder, passes::SceneRenderer& renderer, uint64_t image,
                          uint64_t scene, const passes::CameraHistory& history, bool is_wanted) {
  const bool has_earlier = earlier(image, scene) != nullptr;
  if (has_later_ && image >= stride_) {
    const auto waiting = waiting_.find(image - stride_);
    if (waiting != waiting_.end() && has_earlier) {
      const VkExtent2D extent = renderer.extent();
      readback_.record(recorder, nullptr, extent, {&renderer.flow(), passes::flow_bytes(extent)},
                       image - stride_);
    } else if (waiting != waiting_.end()) {
      waiting->second.awaits_later = false;  // the scene has changed
    }
  }
  std::erase_if(drawn_, [&](const auto& entry) { return entry.first + stride_ <= image; });
  drawn_[image] = {std::make_shared<passes::CameraHistory>(history), scene};
  if (is_wanted) waiting_[image] = {has_earlier, has_later_ && image + stride_ < images_, {}, {}};
}

Result<void> FlowImages::add(sinks::FrameImage&& image) {
  Waiting& waiting = waiting_.at(image.frame_index);
  if (keeps_planes_) {
    waiting.image = std::move(image);
    return {};
  }
  std::vector<uint8_t> motion = take_plane(image, wire::kMotion);
  const std::vector<uint8_t> occlusion = take_plane(image, wire::kOcclusionU32);
  if (waiting.has_earlier) {
    image.flow_backward = read_flow(motion, occlusion);
    // Motion is from the earlier image to this one. Adding 0 leaves no negative zeros.
    for (float& value : image.flow_backward->motion_px) value = 0 - value;
  } else {
    image.flow_backward = no_flow(size_t{image.width} * image.height);
  }
  waiting_bytes_ += sinks::memory_bytes(image);
  waiting.image = std::move(image);
  if (waiting_bytes_ <= kMaxWaitingBytes) return {};
  return too_large("--flow-frames: images that wait for their flow take ", waiting_bytes_, kMaxWaitingBytes);
}

Result<void> FlowImages::deliver(sinks::FrameSink& sink) {
  readback_.poll([&](uint64_t image, VkExtent2D, std::span<const uint8_t> bytes) {
    Waiting& waiting = waiting_.at(image);
    const size_t motion_bytes = bytes.size() / 3 * 2;
    waiting.forward = read_flow(bytes.first(motion_bytes), bytes.subspan(motion_bytes));
    waiting.awaits_later = false;
  });
  while (!waiting_.empty()) {
    Waiting& first = waiting_.begin()->second;
    if (!first.image || first.awaits_later) break;
    sinks::FrameImage image = std::move(*first.image);
    if (!keeps_planes_) waiting_bytes_ -= sinks::memory_bytes(image);
    if (has_later_)
      image.flow_forward =
          first.forward ? std::move(*first.forward) : no_flow(size_t{image.width} * image.height);
    waiting_.erase(waiting_.begin());
    if (auto consumed = sink.consume(std::move(image)); !consumed) return consumed;
  }
  return {};
}

}  // namespace fire3dv::offline

#include "renderer/offline/offline_loop.h"

#include <chrono>
#include <thread>

#include "renderer/app/progress.h"
#include "renderer/app/start.h"

namespace fire3dv::offline {

OfflineLoop::OfflineLoop(const Parts& parts, const FrameTimes& times)
    : parts_(parts), times_(times), frames_(parts.device), captures_(parts.device) {
  // A free camera is fitted to the scene at rest, independent of the first rendered frame.
  const VkExtent2D extent = parts_.renderer.extent();
  (void)parts_.camera.view(parts_.poses,
                           static_cast<float>(extent.width) / static_cast<float>(extent.height));
}

Result<bool> OfflineLoop::run(const Part& part, const std::function<bool(uint64_t frame)>& is_wanted,
                              const std::function<bool()>& should_stop) {
  app::Progress progress("frames:");
  const uint64_t end = part.first + part.frames;
  uint64_t frame = part.first;
  for (; frame < end && !should_stop(); ++frame) {
    if (!is_wanted(frame)) continue;
    advance(frame);
    if (auto drawn = draw(frame); !drawn) return drawn.error();
    if (auto delivered = deliver(); !delivered) return delivered.error();
    progress.update_with_end(frame + 1 - part.first, part.frames);
  }
  parts_.device.wait(parts_.device.last_submitted());
  if (auto delivered = deliver(); !delivered) return delivered.error();
  return frame == end;
}

// Waits until all scene changes of the moment are loaded, so that the image is deterministic.
void OfflineLoop::advance(uint64_t frame) {
  const int64_t line_ns = times_.at_ns(frame);
  parts_.streams.advance(line_ns);
  parts_.scene.follow();
  while (!parts_.scene.settled()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    parts_.scene.follow();
  }
  for (const std::string& note : parts_.streams.take_log_messages()) app::say(note);
  for (const std::string& note : parts_.scene.take_log_messages()) app::say(note);
  if (parts_.animations)
    parts_.poses.set_rest(
        (*parts_.animations)->at(static_cast<double>(parts_.poses.sim_time_ns().value_or(line_ns)) * 1e-9));
}

Result<void> OfflineLoop::draw(uint64_t frame) {
  const VkExtent2D extent = parts_.renderer.extent();
  const Result<passes::PreparedFrame> prepared = parts_.renderer.prepare({.extent = extent});
  if (!prepared) return prepared.error();
  gpu::Recorder& recorder = frames_.begin();
  const passes::View view =
      parts_.camera.view(parts_.poses, static_cast<float>(extent.width) / static_cast<float>(extent.height));
  parts_.renderer.record(*prepared, recorder, frames_.staging(), parts_.poses, view);
  captures_.record(recorder, parts_.renderer.image(), {frame, view.camera, parts_.poses.shown()});
  captures_.submitted(frames_.submit());
  ++images_;
  return {};
}

Result<void> OfflineLoop::deliver() {
  Result<void> delivered = captures_.deliver(parts_.sink);
  (void)frames_.take_finished();  // GPU times are not used
  return delivered;
}

}  // namespace fire3dv::offline

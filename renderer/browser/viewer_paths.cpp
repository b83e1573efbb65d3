// Path-traced images of the live view: which views refine, when they start again, and their progress.
#include <chrono>
#include <string>
#include <utility>

#include "renderer/browser/live_messages.h"
#include "renderer/browser/live_view.h"
#include "renderer/passes/path/path_pass.h"

namespace fire3dv::app {
namespace {

constexpr size_t kMaxRefiningViews = 4;
constexpr auto kTurnTime = std::chrono::seconds(10);  // a viewer that takes longer makes room for another
constexpr auto kPathsPeriod = std::chrono::milliseconds(100);  // between reports of progress

}  // namespace

// Poses that a stream repeats, and markers, start no path-traced image again. Edited cameras start those of
// the viewers that see by them.
void LiveView::note_moment() {
  if (!borrowed_.renderer.traces_paths()) {
    revisions_ = {borrowed_.poses.revision(), borrowed_.scene.updates()};
    return;
  }
  const scene::EditRevisions& edits = borrowed_.scene.edits().revisions();
  revisions_[1] = borrowed_.scene.replaced();
  if (moment_.equals(borrowed_.poses, edits)) return;
  moment_.set(borrowed_.poses, edits);
  ++revisions_[0];
}

bool LiveView::lacks_samples(const Viewer& viewer) const {
  const passes::PathPass* const paths = borrowed_.renderer.path_tracer();
  return paths && viewer.is_refined && viewer.samples < paths->settings().samples_per_pixel;
}

// The samples of a view need memory on the device, so a few views refine at a time, each until its image is
// whole. Returns false if the viewer has to wait.
bool LiveView::take_turn(Viewer& viewer, Clock::time_point now) {
  if (viewer.is_in_turn || !borrowed_.renderer.traces_paths()) return true;
  size_t count = 0;
  Viewer* ended = nullptr;
  for (auto& [number, other] : viewers_) {
    if (!other.is_in_turn) continue;
    ++count;
    const bool is_stuck = other.flight && now - other.flight->begun >= kTurnTime;
    if (!lacks_samples(other) || is_stuck) ended = &other;
  }
  if (count >= kMaxRefiningViews) {
    if (!ended) return false;
    ended->is_in_turn = false;
  }
  return viewer.is_in_turn = true;
}

// Ends a path-traced image of a view that stood, if it is not rendered yet.
void LiveView::withdraw_refinement(serve::ViewerId number, Viewer& viewer) {
  const std::optional<Flight>& flight = viewer.flight;
  if (!borrowed_.renderer.traces_paths() || !flight || !flight->is_refined || flight->number != 0) return;
  wire::ImageRequest withdrawal;
  withdrawal.epoch = kEpoch;
  withdrawal.id = flight->request;
  withdrawal.place = kImagePlace;
  withdrawal.when = wire::ImageWhen::never;
  borrowed_.requests.on_image_request(kFirstViewer + number, withdrawal, nullptr);
  viewer.flight.reset();
  viewer.is_retouched |= !lacks_samples(viewer);  // it was for that
}

// Edits wait for the end of an image that is traced.
void LiveView::withdraw_refinements(Clock::time_point now) {
  if (!borrowed_.renderer.traces_paths()) return;
  for (auto& [number, viewer] : viewers_) {
    withdraw_refinement(number, viewer);
    viewer.changed = now;
  }
}

void LiveView::send_path_progress(serve::ViewerId number, Viewer& viewer, Clock::time_point now) {
  const passes::PathPass* const paths = borrowed_.renderer.path_tracer();
  if (!paths && viewer.paths_text.empty()) return;
  settings::PathProgress progress;
  if (paths) progress.samples_per_pixel = paths->settings().samples_per_pixel;
  // Those of a smaller image in motion do not count.
  if (paths && viewer.is_refined)
    progress.samples = viewer.flight && viewer.flight->samples > 0 ? viewer.flight->samples : viewer.samples;
  const bool stands = !viewer.has_moved && now - viewer.changed >= kRefineAfter;
  const bool waits = stands && !viewer.is_in_turn && !progress.is_whole();
  std::string text = paths_message(progress, waits);
  if (text == viewer.paths_text || (!progress.is_whole() && now - viewer.paths_sent < kPathsPeriod)) return;
  borrowed_.server.send(number, text);
  viewer.paths_text = std::move(text);
  viewer.paths_sent = now;
}

void LiveView::set_samples(state::RequesterId requester, uint64_t request, uint32_t samples) {
  Viewer* const viewer = find(requester);
  if (viewer && viewer->flight && viewer->flight->request == request) viewer->flight->samples = samples;
}

}  // namespace fire3dv::app

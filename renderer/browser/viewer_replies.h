// Replies to image requests of streams and of viewers of the live view, by the requester's number.
#pragma once

#include "renderer/streams/image_request_queue.h"

namespace fire3dv::app {

// Requesters from here on are viewers; those of streams count from 1.
constexpr state::RequesterId kFirstViewer = state::RequesterId{1} << 63;

class ViewerReplies final : public ImageReplies {
 public:
  // Borrowed.
  explicit ViewerReplies(ImageReplies& streams) : streams_(streams) {}
  // Borrowed; null: there are no viewers.
  void set_viewers(ImageReplies* viewers) { viewers_ = viewers; }

  std::optional<Shown> shown(state::RequesterId requester) const override {
    const ImageReplies* const of = target(requester);
    return of ? of->shown(requester) : std::nullopt;
  }
  std::optional<wire::StreamDescription> description(state::RequesterId requester) const override {
    const ImageReplies* const of = target(requester);
    return of ? of->description(requester) : std::nullopt;
  }
  void refuse_image(state::RequesterId requester, const wire::ImageRefused& refused,
                    bool is_logged) override {
    if (ImageReplies* const of = target(requester)) of->refuse_image(requester, refused, is_logged);
  }
  bool send_image(state::RequesterId requester, const wire::ImageFrame& frame,
                  const transport::ListenerLink::FillPixels& fill) override {
    ImageReplies* const of = target(requester);
    return of && of->send_image(requester, frame, fill);
  }
  void set_samples(state::RequesterId requester, uint64_t request, uint32_t samples) override {
    if (ImageReplies* const of = target(requester)) of->set_samples(requester, request, samples);
  }

 private:
  ImageReplies* target(state::RequesterId requester) const {
    return requester >= kFirstViewer ? viewers_ : &streams_;
  }

  ImageReplies& streams_;
  ImageReplies* viewers_ = nullptr;
};

}  // namespace fire3dv::app

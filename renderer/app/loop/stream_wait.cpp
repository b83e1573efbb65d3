#include "renderer/app/loop/stream_wait.h"

#include <sstream>
#include <string>

#include "base/log.h"
#include "base/plural.h"

namespace fire3dv::app {
namespace {

std::string uris_of_links(const StreamReceiver& receiver) {
  std::string uris;
  for (const StreamReceiver::LinkReport& link : receiver.links())
    uris += (uris.empty() ? "" : ", ") + link.uri;
  return uris;
}

}  // namespace

void StreamWait::report(uint64_t images, bool has_timeline) {
  constexpr auto kReportedWait = std::chrono::seconds(3);
  const bool waits = options_.lockstep || options_.exit_when_done || options_.frames != 0;
  if (receiver_.active_streams() != 0 || !waits || has_timeline) {
    streamless_since_.reset();
    return;
  }
  if (!streamless_since_) streamless_since_ = Clock::now();
  bool& reported = receiver_.had_streams() ? reported_ended_ : reported_absent_;
  if (reported || Clock::now() - *streamless_since_ < kReportedWait) return;
  reported = true;
  std::string text = receiver_.had_streams() ? "all streams have ended; waiting for another one at "
                                             : "waiting for a stream at ";
  text += uris_of_links(receiver_);
  if (options_.frames != 0)
    text += ": " + std::to_string(options_.frames - images) + " of " + counted(options_.frames, "image") +
            " to draw";
  if (options_.lockstep) text += "; --lockstep draws one image for each pose frame";
  if (options_.exit_when_done && !receiver_.had_streams())
    text += "; --exit-when-done exits after the first stream that starts from now on";
  if (!options_.exit_when_done) text += "; add --exit-when-done to exit when the last stream ends";
  log_message(text);
}

Result<void> StreamWait::check_timeout() const {
  const std::chrono::duration<double> limit = options_.stream_timeout;
  if (limit.count() == 0 || Clock::now() - started_ < limit) return {};
  std::ostringstream seconds;
  seconds << limit.count();
  return Error{"no pose frame arrived at " + uris_of_links(receiver_) + " within " + seconds.str() +
               " s; start a simulator that publishes there, or raise --wait-for-stream"};
}

}  // namespace fire3dv::app

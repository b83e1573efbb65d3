#include "tools/lab/motion/score.h"

#include <algorithm>
#include <cmath>

#include "renderer/state/playout.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::motion {
namespace {

constexpr int64_t kSampleNs = 16'666'667;
constexpr int64_t kSettlingNs = 5'000'000'000, kRecoveringNs = 2'000'000'000;
constexpr size_t kMaxRecorded = 10'000'000;
constexpr double kMaxBehindMs = 1000;

// Time span on the receiver's clock.
struct Span {
  int64_t begin_ns = 0, end_ns = 0;
};

std::vector<Span> interruptions_of(const Recording& recording) {
  std::vector<Span> spans;
  state::Liveness liveness;
  int64_t last_ns = 0;
  for (const Arrival& arrival : recording) {
    if (liveness.at(arrival.received_ns) != state::Condition::live)
      spans.push_back({last_ns, arrival.received_ns + kRecoveringNs});
    liveness.on_frame(last_ns = arrival.received_ns);
  }
  return spans;
}

struct Sample {
  int64_t now_ns = 0;
  wire::Affine3x4 seen;
};

// Displayed pose of a renderer over time, for one playout mode.
class Viewer {
 public:
  explicit Viewer(Way way) : way_(way) {}

  void take(const Arrival& arrival) {
    newest_ = reference_pose(arrival.sim_time_ns);
    if (way_ == Way::latest) return;
    wire::PoseFrameHeader header;
    header.epoch = 1;
    header.sequence = arrival.sequence;
    header.sim_time_ns = arrival.sim_time_ns;
    clock_.on_frame(arrival.publish_time_ns, arrival.received_ns);
    playout_.add(header, {&*newest_, 1}, clock_.soonest_ns(arrival.publish_time_ns), arrival.received_ns);
  }
  std::optional<wire::Affine3x4> at(int64_t now_ns) {
    if (way_ == Way::latest) return newest_;
    const auto shown = playout_.at(now_ns);
    return shown ? std::optional<wire::Affine3x4>(shown->poses[0]) : std::nullopt;
  }

 private:
  Way way_;
  std::optional<wire::Affine3x4> newest_;
  state::ClockOffset clock_;
  state::Playout playout_;
};

std::vector<Sample> sample_poses(const Recording& recording, Way way) {
  const std::vector<Span> left_out = interruptions_of(recording);
  std::vector<Sample> samples;
  Viewer viewer(way);
  size_t next = 0;
  const int64_t begin_ns = recording.front().received_ns;
  for (int64_t now_ns = begin_ns; now_ns <= recording.back().received_ns; now_ns += kSampleNs) {
    for (; next < recording.size() && recording[next].received_ns <= now_ns; ++next)
      viewer.take(recording[next]);
    const auto seen = viewer.at(now_ns);
    const bool out = std::any_of(left_out.begin(), left_out.end(), [&](const Span& span) {
      return now_ns >= span.begin_ns && now_ns < span.end_ns;
    });
    if (seen && !out && now_ns - begin_ns >= kSettlingNs) samples.push_back({now_ns, *seen});
  }
  return samples;
}

// Error against the true motion behind_ms earlier.
Score against(const std::vector<Sample>& samples, int64_t sim_from_now_ns, double behind_ms) {
  Score score;
  score.behind_ms = behind_ms;
  score.samples = samples.size();
  double squares = 0;
  for (const Sample& sample : samples) {
    const auto truth =
        reference_pose(sample.now_ns + sim_from_now_ns - static_cast<int64_t>(behind_ms * 1e6));
    const double off_mm = 1e3 * distance_m(sample.seen, truth);
    squares += off_mm * off_mm;
    score.max_mm = std::max(score.max_mm, off_mm);
  }
  score.rms_mm = std::sqrt(squares / static_cast<double>(samples.size()));
  return score;
}

}  // namespace

Score score(const Recording& recording, Way way) {
  if (recording.empty()) return {};
  const std::vector<Sample> samples = sample_poses(recording, way);
  if (samples.empty()) return {};
  // Offset from the receiver's clock to simulated time, from the fastest frame.
  int64_t sim_from_now_ns = INT64_MIN;
  for (const Arrival& arrival : recording)
    sim_from_now_ns = std::max(sim_from_now_ns, arrival.sim_time_ns - arrival.received_ns);
  // Within a quarter of the circle the error has a single minimum, so ternary search applies.
  double low_ms = -10, high_ms = kMaxBehindMs;
  while (high_ms - low_ms > 0.02) {
    const double third_ms = (high_ms - low_ms) / 3;
    const bool left = against(samples, sim_from_now_ns, low_ms + third_ms).rms_mm <
                      against(samples, sim_from_now_ns, high_ms - third_ms).rms_mm;
    (left ? high_ms : low_ms) += left ? -third_ms : third_ms;
  }
  return against(samples, sim_from_now_ns, (low_ms + high_ms) / 2);
}

std::string text_of(const Recording& recording) {
  std::string text;
  for (const Arrival& arrival : recording)
    text += std::to_string(arrival.sequence) + ' ' + std::to_string(arrival.sim_time_ns) + ' ' +
            std::to_string(arrival.publish_time_ns) + ' ' + std::to_string(arrival.received_ns) + '\n';
  return text;
}

std::optional<Recording> recording_of(std::istream& text) {
  Recording recording;
  for (Arrival arrival;
       text >> arrival.sequence >> arrival.sim_time_ns >> arrival.publish_time_ns >> arrival.received_ns;) {
    const bool ordered = recording.empty() || (arrival.sequence > recording.back().sequence &&
                                               arrival.received_ns >= recording.back().received_ns);
    if (!ordered || arrival.received_ns <= 0 || recording.size() == kMaxRecorded) return {};
    recording.push_back(arrival);
  }
  if (!text.eof() || recording.empty()) return {};
  return recording;
}

wire::Affine3x4 reference_pose(int64_t sim_time_ns) {
  const double angle_rad = static_cast<double>(sim_time_ns) * 1e-9;
  const auto c = static_cast<float>(std::cos(angle_rad)), s = static_cast<float>(std::sin(angle_rad));
  wire::Affine3x4 pose;
  pose.m = {c, -s, 0, c, s, c, 0, s, 0, 0, 1, 0};
  return pose;
}

double distance_m(const wire::Affine3x4& a, const wire::Affine3x4& b) {
  const auto along = [&](size_t i) { return static_cast<double>(a.m[i]) - static_cast<double>(b.m[i]); };
  return std::hypot(along(3), along(7), along(11));
}

}  // namespace fire3dv::motion

#include "renderer/offline/timeline.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "base/numbers.h"
#include "base/plural.h"
#include "protocol/wire/check.h"
#include "renderer/offline/recorded_streams.h"

namespace fire3dv::offline {

namespace {

// Limits that keep the products in at_ns() within int64_t.
constexpr int64_t kMaxNumerator = 1'000'000'000, kMaxDenominator = 100'000;

std::optional<int64_t> whole_number(std::string_view text) {
  return text.starts_with('-') ? std::nullopt : parse_number<int64_t>(text);
}

// Parses "29.97" as 2997/100.
std::optional<FrameRate> decimal(const std::string& text) {
  const size_t point = text.find('.');
  if (point == std::string::npos) {
    const auto whole = whole_number(text);
    return whole ? std::optional(FrameRate{*whole, 1}) : std::nullopt;
  }
  const size_t decimals = text.size() - point - 1;
  const auto digits = whole_number(text.substr(0, point) + text.substr(point + 1));
  if (decimals == 0 || decimals > 3 || !digits) return {};
  int64_t scale = 1;
  for (size_t i = 0; i < decimals; ++i) scale *= 10;
  return FrameRate{*digits, scale};
}

std::optional<FrameRate> fraction(const std::string& text) {
  const size_t slash = text.find('/');
  if (slash == std::string::npos) return decimal(text);
  const auto numerator = whole_number(text.substr(0, slash)),
             denominator = whole_number(text.substr(slash + 1));
  if (!numerator || !denominator) return {};
  return FrameRate{*numerator, *denominator};
}

}  // namespace

Result<FrameRate> parse_frame_rate(const std::string& text) {
  std::optional<FrameRate> rate = fraction(text);
  if (rate && rate->numerator > 0 && rate->denominator > 0) {
    const int64_t common = std::gcd(rate->numerator, rate->denominator);
    rate->numerator /= common;
    rate->denominator /= common;
    if (rate->numerator <= kMaxNumerator && rate->denominator <= kMaxDenominator &&
        rate->numerator / 100'000 <= rate->denominator && rate->denominator / 1000 <= rate->numerator)
      return *rate;
  }
  return Error{"--fps " + text +
               ": must be frames a second from 0.001 to 100000, such as 30, 29.97 or 30000/1001"};
}

std::string to_text(const FrameRate& rate) {
  return std::to_string(rate.numerator) +
         (rate.denominator == 1 ? "" : "/" + std::to_string(rate.denominator));
}

int64_t FrameTimes::at_ns(uint64_t frame) const {
  if (is_recorded) return recorded_ns[frame];
  const auto scaled = static_cast<int64_t>(frame) * rate.denominator;
  return first_ns + scaled / rate.numerator * kSecondNs +
         scaled % rate.numerator * kSecondNs / rate.numerator;
}

Result<FrameTimes> frame_times(int64_t first_ns, int64_t last_ns, const FrameRate& rate) {
  FrameTimes times;
  times.first_ns = first_ns;
  times.rate = rate;
  if (last_ns < first_ns) return times;
  const double wanted = static_cast<double>(last_ns - first_ns) * 1e-9 * static_cast<double>(rate.numerator) /
                        static_cast<double>(rate.denominator);
  if (wanted >= static_cast<double>(kMaxFrames))
    return Error{"that would be more than " + std::to_string(kMaxFrames) +
                 " frames: choose a part with --start and --end, or fewer frames a second with --fps"};
  // Last frame not after the end: floating point is exact within one frame.
  times.frames = static_cast<uint64_t>(wanted) + 2;
  while (times.at_ns(times.frames - 1) > last_ns) --times.frames;
  return times;
}

Result<FrameTimes> recorded_frame_times(int64_t first_ns, int64_t last_ns,
                                        const std::vector<int64_t>& recorded_ns) {
  if (recorded_ns.size() > kMaxRecordedFrames)
    return Error{"the recording has more than " + std::to_string(kMaxRecordedFrames) +
                 " frames: choose how many a second are drawn with --rate"};
  FrameTimes times;
  times.is_recorded = true;
  const auto first = std::lower_bound(recorded_ns.begin(), recorded_ns.end(), first_ns);
  const auto end = std::upper_bound(first, recorded_ns.end(), last_ns);
  times.recorded_ns.assign(first, end);
  times.frames = times.recorded_ns.size();
  times.first_ns = times.frames != 0 ? times.recorded_ns.front() : first_ns;
  return times;
}

Part part_of(uint64_t frames, uint32_t index, uint32_t count) {
  const uint64_t first = frames * (index - 1) / count, end = frames * index / count;
  return {first, end - first};
}

namespace {

constexpr size_t kMaxStreams = 64;
constexpr size_t kMaxSegments = 1'000'000;  // of all streams; limit of runs, too
constexpr size_t kMaxGuidePoints = 1 << 20;
constexpr int64_t kSameClockNs = kSecondNs / 10;
constexpr int64_t kMaxLineNs = (int64_t{1} << 62) - 1;

// Sum and difference, clamped to the range of the type: sums of distant times are refused, not wrapped.
int64_t clamped_sum(int64_t a, int64_t b) {
  int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return a < 0 ? kAlways : kNever;
}
int64_t clamped_difference(int64_t a, int64_t b) {
  int64_t difference = 0;
  if (!__builtin_sub_overflow(a, b, &difference)) return difference;
  return a < 0 ? kAlways : kNever;
}
bool is_near(int64_t a, int64_t b) {
  const int64_t difference = clamped_difference(a, b);
  return difference >= -kSameClockNs && difference <= kSameClockNs;
}
bool is_too_far(int64_t line_ns) {
  return line_ns < -kMaxLineNs || line_ns > kMaxLineNs;
}

// Empty if every message was used.
std::string unusable_note(const std::string& stream, const StreamFrames::Unusable& unusable) {
  std::string reasons;
  const auto add = [&](uint64_t count, const char* what, const char* reason) {
    if (count != 0) reasons += (reasons.empty() ? "" : ", ") + counted(count, what) + reason;
  };
  add(unusable.malformed, "message", " not understood");
  add(unusable.other_version, "description", " of another protocol version");
  add(unusable.before_description, "message", " before the description of the stream");
  add(unusable.distant, "pose frame", " with a simulated time beyond 146 years");
  if (reasons.empty()) return {};
  return "stream \"" + wire::printable(stream) + "\": " + reasons + " left out";
}

}  // namespace

class Timeline::Builder {
 public:
  Builder(Timeline& line, const record::Playback& playback)
      : line_(line), playback_(playback), streams_(playback.streams().size()) {
    line_.streams_.resize(streams_.size());
  }

  Result<void> choose_guide(const std::string& name);
  Result<void> take(const record::Played& played);
  Result<void> finish();

 private:
  // Simulator time range of a segment before its placement.
  struct Span {
    int64_t first_sim_ns = 0, last_sim_ns = 0;
    int64_t step_ns = 1;  // between its last two frames
    uint64_t frames = 0;
    size_t run = 0;
    bool placed = false;
  };
  struct Building {
    StreamFrames frames;
    std::vector<Span> spans;
    int64_t last_ns = kAlways;  // newest placed frame
  };

  Result<void> begin_segment(size_t stream, int64_t sim_ns);
  void place(size_t stream, size_t segment, int64_t line_from_sim_ns);
  Result<void> guide_has_come(int64_t line_ns);
  Error too_far_apart(size_t stream) const;
  bool room() const { return segments_ < kMaxSegments; }

  Timeline& line_;
  const record::Playback& playback_;
  std::vector<Building> streams_;
  std::optional<size_t> guide_;
  bool guide_runs_ = false;   // its first frame was read
  int64_t guide_now_ns_ = 0;  // on the timeline
  size_t segments_ = 0;
};

Result<void> Timeline::Builder::choose_guide(const std::string& name) {
  if (streams_.size() > kMaxStreams)
    return Error{wire::printable(const_cast<record::Playback&>(playback_).reader().name(), 4096) + " holds " +
                 std::to_string(streams_.size()) + " streams; " + std::to_string(kMaxStreams) +
                 " at most can be rendered together"};
  if (name.empty()) return {};
  std::string known;
  for (size_t i = 0; i < streams_.size(); ++i) {
    if (playback_.streams()[i].name == name) guide_ = i;
    known += (i ? ", \"" : "\"") + wire::printable(playback_.streams()[i].name) + "\"";
  }
  if (!guide_)
    return Error{"--clock \"" + wire::printable(name) + "\" is not in the recording; it has " + known};
  return {};
}

Result<void> Timeline::Builder::take(const record::Played& played) {
  const size_t stream = played.stream;
  Building& building = streams_[stream];
  StreamTimes& times = line_.streams_[stream];
  const StreamFrames::Changes taken = building.frames.take(played);
  if (taken.began) {
    if (!room()) return Error{"the recording has too many runs; render a part of it (--start, --end)"};
    ++segments_;
    times.runs.emplace_back();
  }
  if (!taken.frame) return {};
  const int64_t sim_ns = building.frames.header().sim_time_ns;
  if (!guide_) guide_ = stream;
  if (taken.segment) {
    if (auto begun = begin_segment(stream, sim_ns); !begun) return begun;
  }
  Span& span = building.spans.back();
  if (span.frames++ > 0) span.step_ns = std::clamp<int64_t>(sim_ns - span.last_sim_ns, 1, kSecondNs);
  span.last_sim_ns = sim_ns;
  Run& run = times.runs.back();
  ++run.frames;
  ++line_.frames_;
  if (!span.placed) return {};
  const int64_t line_ns = clamped_sum(sim_ns, times.segments.back().line_from_sim_ns);
  if (is_too_far(line_ns)) return too_far_apart(stream);
  run.first_ns = std::min(run.first_ns, line_ns);
  building.last_ns = line_ns;
  if (stream != *guide_) return {};
  if (guide_runs_ && line_ns - guide_now_ns_ > line_.longest_pause_.length_ns)
    line_.longest_pause_ = {guide_now_ns_, line_ns - guide_now_ns_};
  guide_now_ns_ = line_ns;
  line_.remember(played.log_time_ns, line_ns);
  std::vector<int64_t>& recorded_ns = line_.recorded_ns_;
  if (line_.lists_frames_ && recorded_ns.size() <= kMaxRecordedFrames &&
      (recorded_ns.empty() || line_ns > recorded_ns.back()))
    recorded_ns.push_back(line_ns);
  if (!std::exchange(guide_runs_, true)) return guide_has_come(line_ns);
  return {};
}

Error Timeline::Builder::too_far_apart(size_t stream) const {
  return Error{"the simulated times of stream \"" + wire::printable(playback_.streams()[stream].name) +
               "\" are too far apart to be laid on one line; render another stream's clock with --clock"};
}

Result<void> Timeline::Builder::begin_segment(size_t stream, int64_t sim_ns) {
  if (!room())
    return Error{"simulated time goes back too often in the recording; render a part of it (--start, --end)"};
  ++segments_;
  Building& building = streams_[stream];
  StreamTimes& times = line_.streams_[stream];
  const std::optional<Span> before =
      building.spans.empty() ? std::nullopt : std::optional(building.spans.back());
  Span span;
  span.first_sim_ns = sim_ns;
  span.run = times.runs.size() - 1;
  building.spans.push_back(span);
  times.segments.emplace_back();
  const bool is_guide = stream == *guide_;
  if (!is_guide && !guide_runs_) return {};  // placed when the guide's first frame is read
  int64_t first_ns = sim_ns;
  if (!is_guide) {
    const int64_t by_guide_ns = clamped_sum(sim_ns, line_.streams_[*guide_].segments.back().line_from_sim_ns);
    first_ns = is_near(by_guide_ns, guide_now_ns_) ? by_guide_ns : guide_now_ns_;
  }
  // Segments of one stream must not overlap on the timeline.
  if (before && (is_guide || first_ns <= building.last_ns)) first_ns = building.last_ns + before->step_ns;
  place(stream, building.spans.size() - 1, clamped_difference(first_ns, sim_ns));
  return {};
}

void Timeline::Builder::place(size_t stream, size_t segment, int64_t line_from_sim_ns) {
  line_.streams_[stream].segments[segment].line_from_sim_ns = line_from_sim_ns;
  streams_[stream].spans[segment].placed = true;
}

// Places segments that precede the guide: the newest by its newest frame, earlier ones end to end before it.
Result<void> Timeline::Builder::guide_has_come(int64_t line_ns) {
  for (size_t stream = 0; stream < streams_.size(); ++stream) {
    Building& building = streams_[stream];
    if (stream == *guide_ || building.spans.empty()) continue;
    const Span& newest = building.spans.back();
    const bool same = is_near(newest.last_sim_ns, line_ns);
    place(stream, building.spans.size() - 1, same ? 0 : line_ns - newest.last_sim_ns);
    for (size_t i = building.spans.size() - 1; i-- > 0;) {
      const int64_t next_ns = clamped_sum(building.spans[i + 1].first_sim_ns,
                                          line_.streams_[stream].segments[i + 1].line_from_sim_ns);
      // Each segment moves farther back.
      if (is_too_far(next_ns)) return too_far_apart(stream);
      place(stream, i,
            clamped_difference(next_ns - building.spans[i].step_ns, building.spans[i].last_sim_ns));
    }
    building.last_ns =
        clamped_sum(newest.last_sim_ns, line_.streams_[stream].segments.back().line_from_sim_ns);
    for (size_t i = 0; i < building.spans.size(); ++i) {
      Run& run = line_.streams_[stream].runs[building.spans[i].run];
      run.first_ns = std::min(run.first_ns, clamped_sum(building.spans[i].first_sim_ns,
                                                        line_.streams_[stream].segments[i].line_from_sim_ns));
    }
  }
  return {};
}

Result<void> Timeline::Builder::finish() {
  const std::string name = wire::printable(const_cast<record::Playback&>(playback_).reader().name(), 4096);
  for (size_t stream = 0; stream < streams_.size(); ++stream) {
    const StreamFrames::Unusable& unusable = streams_[stream].frames.unusable();
    line_.unusable_ += unusable.count();
    std::string note = unusable_note(playback_.streams()[stream].name, unusable);
    if (!note.empty()) line_.unusable_notes_.push_back(std::move(note));
  }
  if (!guide_ && !line_.unusable_notes_.empty())
    return Error{name + " holds no pose frame that can be rendered: " + line_.unusable_notes_.front()};
  if (!guide_) return Error{name + " holds no whole pose frame; there is nothing to render"};
  line_.guide_name_ = playback_.streams()[*guide_].name;
  if (!guide_runs_)
    return Error{"stream \"" + wire::printable(line_.guide_name_) + "\" of " + name +
                 " holds no whole pose frame; name another with --clock"};
  for (size_t stream = 0; stream < streams_.size(); ++stream) {
    for (size_t i = 0; i < streams_[stream].spans.size(); ++i) {
      const Span& span = streams_[stream].spans[i];
      Segment& segment = line_.streams_[stream].segments[i];
      const int64_t first_ns = clamped_sum(span.first_sim_ns, segment.line_from_sim_ns);
      const int64_t last_ns = clamped_sum(span.last_sim_ns, segment.line_from_sim_ns);
      if (is_too_far(first_ns) || is_too_far(last_ns))
        return Error{"simulated times in " + name + " are too far apart to be laid on one line"};
      line_.first_ns_ = std::min(line_.first_ns_, first_ns);
      line_.last_ns_ = std::max(line_.last_ns_, last_ns);
      const auto intervals = static_cast<int64_t>(std::max<uint64_t>(span.frames, 2) - 1);
      const int64_t interval_ns = (span.last_sim_ns - span.first_sim_ns) / intervals;
      segment.hold_ns = std::max(kSecondNs, std::min(interval_ns, kNever / 4) * 4);
    }
  }
  return {};
}

Result<Timeline> Timeline::read(record::Playback& playback, const std::string& clock,
                                const OnProgress& on_progress, bool lists_frames) {
  Timeline line;
  line.lists_frames_ = lists_frames;
  Builder builder(line, playback);
  if (auto chosen = builder.choose_guide(clock); !chosen) return chosen.error();
  playback.rewind();
  record::Played played;
  constexpr uint64_t kMessagesBetweenLooks = 1000;
  for (uint64_t messages = 0;; ++messages) {
    const record::Playback::Step step = playback.next(played);
    if (step == record::Playback::Step::end) break;
    if (step == record::Playback::Step::damaged) {
      ++line.damaged_;
      continue;
    }
    if (auto taken = builder.take(played); !taken) return taken.error();
    const uint64_t begun_ns = playback.start_ns();
    if (messages % kMessagesBetweenLooks == 0 && on_progress &&
        !on_progress(std::max(played.log_time_ns, begun_ns) - begun_ns, playback.end_ns() - begun_ns))
      return Error{"stopped while the recording was read"};
  }
  if (auto finished = builder.finish(); !finished) return finished.error();
  line.unusable_ += playback.refused();
  return line;
}

// Thins out guide points: close ones are redundant; at the limit every other one is dropped.
void Timeline::remember(uint64_t log_time_ns, int64_t line_ns) {
  if (!guide_.empty() && log_time_ns < guide_.back().first + guide_spacing_ns_) return;
  guide_.emplace_back(log_time_ns, line_ns);
  if (guide_.size() < kMaxGuidePoints) return;
  for (size_t i = 0; i < guide_.size() / 2; ++i) guide_[i] = guide_[2 * i];
  guide_.resize(guide_.size() / 2);
  guide_spacing_ns_ *= 2;
}

int64_t Timeline::guide_at(uint64_t log_time_ns) const {
  const auto after = std::upper_bound(guide_.begin(), guide_.end(), log_time_ns,
                                      [](uint64_t time, const auto& point) { return time < point.first; });
  return after == guide_.begin() ? kAlways : std::prev(after)->second;
}

}  // namespace fire3dv::offline

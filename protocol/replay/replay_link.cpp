#include "protocol/replay/replay_link.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "base/clock.h"
#include "protocol/wire/check.h"

namespace fire3dv::replay {
namespace {

using transport::LinkEvent;

// Time limit of reading in one poll: rendering continues even if the recording is due faster than it is read.
constexpr int64_t kMaxReadingNs = 8 * kMillisecondNs;
constexpr int kMessagesPerClockRead = 32;
// Search window of a seek. Streams send a whole frame at least every 250 ms (SPEC 4); the far window is for
// slower streams.
constexpr uint64_t kLookBackNs = 300'000'000;
constexpr uint64_t kFarLookBackNs = 5'000'000'000;

uint64_t plus_seconds(uint64_t from_ns, double seconds, uint64_t max_ns) {
  const double after_ns = seconds * 1e9;
  return after_ns >= static_cast<double>(max_ns - from_ns) ? max_ns
                                                           : from_ns + static_cast<uint64_t>(after_ns);
}

}  // namespace

class ReplayLink::TimeSlice {
 public:
  static TimeSlice without_end() { return TimeSlice(INT64_MAX); }
  static TimeSlice of_a_poll() { return TimeSlice(monotonic_ns() + kMaxReadingNs); }

  // Called after each message. Reads the clock only every kMessagesPerClockRead messages.
  bool is_over() { return ++messages_ % kMessagesPerClockRead == 0 && is_late(); }
  // Called after longer operations.
  bool is_late() const { return monotonic_ns() > until_ns_; }

 private:
  explicit TimeSlice(int64_t until_ns) : until_ns_(until_ns) {}

  int64_t until_ns_;
  int messages_ = 0;
};

Result<std::unique_ptr<ReplayLink>> ReplayLink::open(const std::string& path, const ReplayOptions& options) {
  auto source = record::open_source(path);
  if (!source) return source.error();
  return open(std::move(*source), options);
}

Result<std::unique_ptr<ReplayLink>> ReplayLink::open(std::unique_ptr<record::Source> source,
                                                     const ReplayOptions& options) {
  auto playback = record::Playback::open(std::move(source), options.limits);
  if (!playback) return playback.error();
  std::unique_ptr<ReplayLink> link(new ReplayLink(std::move(*playback), options));
  if (auto good = link->choose_streams(options.streams); !good) return good.error();
  // Regardless of the recording's length.
  const bool names_nothing = options.end_s > 0 && options.start_s > options.end_s;
  if (names_nothing || link->start_ns_ > link->end_ns_)
    return Error{"--start " + std::to_string(options.start_s) + " is behind --end " +
                 std::to_string(options.end_s) + "; name an earlier one"};
  if (const std::string& damage = link->playback_.reader().index().damage; !damage.empty())
    link->notes_.push_back(wire::printable(link->playback_.reader().name(), 4096) + ": " + damage);
  const int64_t now_ns = monotonic_ns();
  link->clock_.set_speed(options.speed, now_ns);
  if (options.start_s > 0) {
    for (const auto& player : link->players_)
      if (player) player->jump(false);
    link->show_state_at(link->start_ns_);
  } else {
    link->playback_.rewind();
    link->clock_.set_position(link->start_ns_, now_ns);
  }
  return link;
}

ReplayLink::ReplayLink(record::Playback playback, const ReplayOptions& options)
    : playback_(std::move(playback)),
      start_ns_(playback_.start_ns()),
      end_ns_(playback_.end_ns()),
      each_frame_(options.each_frame),
      end_streams_(options.end_streams),
      looping_(options.loop) {
  if (options.end_s > 0) end_ns_ = plus_seconds(start_ns_, options.end_s, end_ns_);
  if (options.start_s > 0) start_ns_ = plus_seconds(start_ns_, options.start_s, playback_.end_ns());
}

Result<void> ReplayLink::choose_streams(const std::vector<std::string>& names) {
  const auto& streams = playback_.streams();
  players_.resize(streams.size());
  std::string known;
  for (size_t i = 0; i < streams.size(); ++i) {
    known += (i ? ", \"" : "\"") + wire::printable(streams[i].name) + "\"";
    if (names.empty() || std::ranges::find(names, streams[i].name) != names.end())
      players_[i] = std::make_unique<StreamPlayer>(std::make_unique<QueueLink>(queue_, i + 1), false);
  }
  for (const std::string& name : names)
    if (std::ranges::find(streams, name, &record::Playback::Stream::name) == streams.end())
      return Error{"there is no stream \"" + wire::printable(name) + "\" in the recording; it has " + known};
  first_chosen_ = static_cast<size_t>(
      std::ranges::find_if(players_, [](const auto& player) { return player != nullptr; }) -
      players_.begin());
  return {};
}

ReplayLink::Fetched ReplayLink::fetch(TimeSlice& turn) {
  if (pending_) return Fetched::message;
  record::Played played;
  for (;;) {
    const record::Playback::Step step = playback_.next(played);
    if (step == record::Playback::Step::end) return Fetched::end;
    if (step == record::Playback::Step::damaged) {
      if (damaged_++ == 0) notes_.push_back(playback_.problem());
      if (turn.is_late()) return Fetched::later;
      continue;
    }
    if (played.log_time_ns > end_ns_) return Fetched::end;
    pending_ = played;
    // A message follows, so these goodbyes are not the last ones.
    if (played.kind != record::Played::Kind::goodbye && players_[played.stream]) send_goodbyes();
    return Fetched::message;
  }
}

void ReplayLink::send_goodbyes() {
  for (const size_t stream : delayed_goodbyes_) players_[stream]->end();
  delayed_goodbyes_.clear();
}

void ReplayLink::play_pending() {
  const record::Played played = *std::exchange(pending_, std::nullopt);
  if (!players_[played.stream]) return;
  if (played.kind == record::Played::Kind::goodbye) {
    delayed_goodbyes_.push_back(played.stream);
    return;
  }
  StreamPlayer& player = *players_[played.stream];
  player.set_publish_time(static_cast<uint64_t>(
      clock_.unpaced() || each_frame_ || step_ ? monotonic_ns() : clock_.due_ns(played.log_time_ns)));
  const uint64_t before = player.counts().frames;
  const std::optional<uint64_t> assembled = player.assembled_sequence();
  (void)player.play(played);  // cannot fail: the queue is unbounded
  const std::optional<uint64_t> now_assembled = player.assembled_sequence();
  if (now_assembled && now_assembled != assembled) assembled_ns_ = played.log_time_ns;
  if (player.counts().frames == before) return;
  newest_ = played.stream;
  shown_ns_ = played.log_time_ns;
}

bool ReplayLink::all_have_frames() const {
  return std::ranges::all_of(
      players_, [](const auto& player) { return !player || !player->is_live() || player->has_assembled(); });
}

void ReplayLink::show_state_at(uint64_t log_time_ns) {
  TimeSlice turn = TimeSlice::without_end();
  begin_seek(log_time_ns, kLookBackNs);
  (void)continue_seek(turn);
}

void ReplayLink::begin_seek(uint64_t log_time_ns, uint64_t look_back_ns) {
  const uint64_t first_ns = playback_.start_ns();
  const uint64_t from_ns = log_time_ns - first_ns > look_back_ns ? log_time_ns - look_back_ns : first_ns;
  showing_ = {log_time_ns, look_back_ns, queue_.size()};
  pending_.reset();
  delayed_goodbyes_.clear();
  at_end_ = false;
  assembled_ns_ = 0;
  from_ns == first_ns ? playback_.rewind() : playback_.seek(from_ns);
  for (const auto& player : players_)
    if (player) player->begin_assembly();
}

bool ReplayLink::continue_seek(TimeSlice& turn) {
  for (;;) {
    const Fetched fetched = fetch(turn);
    if (fetched == Fetched::later) return false;
    const uint64_t log_time_ns = showing_->log_time_ns;
    if (fetched == Fetched::message && pending_->log_time_ns <= log_time_ns) {
      play_pending();
      if (turn.is_over()) return false;
      continue;
    }
    if (all_have_frames() || showing_->look_back_ns >= kFarLookBackNs ||
        log_time_ns - playback_.start_ns() <= showing_->look_back_ns)
      break;
    for (const auto& player : players_)
      if (player) player->jump(false);
    queue_.resize(showing_->queued);
    begin_seek(log_time_ns, kFarLookBackNs);
  }
  const int64_t now_ns = monotonic_ns();
  clock_.set_position(showing_->log_time_ns, now_ns);
  for (size_t i = 0; i < players_.size(); ++i) {
    if (!players_[i]) continue;
    players_[i]->set_publish_time(static_cast<uint64_t>(now_ns));
    if (players_[i]->publish_assembled()) newest_ = i;
  }
  shown_ns_ = assembled_ns_;
  frames_at_round_ = frames() - 1;  // at least one frame to show
  showing_.reset();
  return true;
}

void ReplayLink::seek(uint64_t log_time_ns) {
  queue_.clear();
  for (const auto& player : players_) {
    if (!player) continue;
    player->end();
    player->jump(true);
  }
  newest_.reset();  // nothing is shown before the first frame
  show_state_at(std::clamp(log_time_ns, start_ns_, end_ns_));
}

Result<void> ReplayLink::seek_sim_time(int64_t sim_time_ns) {
  pending_.reset();  // the search moves the playback
  const auto found = record::log_time_of(playback_, first_chosen_, sim_time_ns);
  if (found) {
    seek(*found);
    return {};
  }
  seek(clock_.position_ns(monotonic_ns()));
  return Error{"no frame of \"" + wire::printable(playback_.streams()[first_chosen_].name) +
               "\" is of simulated time " + std::to_string(sim_time_ns) + " ns or later"};
}

void ReplayLink::play() {
  if (at_end_) seek(start_ns_);
  begun_ = true;
  clock_.set_playing(true, monotonic_ns());
}

void ReplayLink::pause() {
  begun_ = true;
  clock_.set_playing(false, monotonic_ns());
}

void ReplayLink::step() {
  pause();
  step_ = !at_end_;
}

void ReplayLink::step_back() {
  pause();
  step_ = false;
  const uint64_t shown_ns = shown_ns_;
  if (shown_ns <= start_ns_) return;
  seek(shown_ns - 1);
  if (shown_ns_ == 0) seek(shown_ns);  // it was the first frame
  if (shown_ns_ != 0) clock_.set_position(std::max(shown_ns_, start_ns_), monotonic_ns());
}

void ReplayLink::set_speed(double speed) {
  clock_.set_speed(speed, monotonic_ns());
}

uint64_t ReplayLink::frames() const {
  uint64_t sum = 0;
  for (const auto& player : players_)
    if (player) sum += player->counts().frames;
  return sum;
}

void ReplayLink::reach_end() {
  if (looping_ && clock_.playing() && frames() != frames_at_round_) {
    for (const auto& player : players_)
      if (player) player->jump(true);
    delayed_goodbyes_.clear();
    at_end_ = false;
    frames_at_round_ = frames();
    if (start_ns_ > playback_.start_ns()) {
      begin_seek(start_ns_, kLookBackNs);
    } else {
      playback_.rewind();
      clock_.set_position(start_ns_, monotonic_ns());
    }
    return;
  }
  at_end_ = true;
  step_ = false;
  clock_.set_position(end_ns_, monotonic_ns());
  clock_.set_playing(false, monotonic_ns());
  if (!end_streams_) return;
  delayed_goodbyes_.clear();
  for (const auto& player : players_)
    if (player) player->end();
}

void ReplayLink::run() {
  TimeSlice turn = TimeSlice::of_a_poll();
  if (!std::exchange(begun_, true)) clock_.set_playing(true, monotonic_ns());
  if (showing_ && (!continue_seek(turn) || each_frame_)) return;
  while (!at_end_ && (clock_.playing() || step_)) {
    const Fetched fetched = fetch(turn);
    if (fetched == Fetched::later) return;
    if (fetched == Fetched::end) {
      const bool loops = looping_ && clock_.playing();
      // Shows the last frame for its duration.
      if (loops && !each_frame_ && !clock_.unpaced() && clock_.position_ns(monotonic_ns()) < end_ns_) return;
      reach_end();
      return;  // at most one round per poll: unpaced loops would otherwise never return
    }
    const bool paced = !each_frame_ && !step_ && !clock_.unpaced();
    if (paced && pending_->log_time_ns > clock_.position_ns(monotonic_ns())) {
      const int64_t wait_ns = clock_.due_ns(pending_->log_time_ns) - monotonic_ns();
      if (wait_ns > kLongWaitNs &&
          std::exchange(long_wait_for_ns_, pending_->log_time_ns) != pending_->log_time_ns)
        notes_.push_back("info: " + long_wait_text(wait_ns, pending_->log_time_ns - playback_.start_ns()));
      return;
    }
    if (!paced) clock_.set_position(pending_->log_time_ns, monotonic_ns());
    const uint64_t before = frames();
    play_pending();
    if (frames() != before && (each_frame_ || step_)) {
      step_ = false;
      return;
    }
    if (turn.is_over()) return;
  }
}

void ReplayLink::poll(const std::function<void(const LinkEvent&)>& on_event) {
  run();
  peers_ = static_cast<uint32_t>(
      std::ranges::count_if(players_, [](const auto& player) { return player && player->is_live(); }));
  for (const std::string& note : std::exchange(notes_, {})) on_event({LinkEvent::Kind::note, 0, {}, note, 0});
  // Holds back the events of a running search: a search with the far window may replace them.
  for (; !queue_.empty() && (!showing_ || showing_->queued != 0); queue_.pop_front()) {
    if (showing_) --showing_->queued;
    const QueuedEvent& event = queue_.front();
    ++messages_;
    bytes_ += event.message.size();
    on_event({event.kind, event.peer, event.message, {}, 0});
  }
}

void ReplayLink::wait(std::chrono::nanoseconds timeout) {
  if (!queue_.empty() || step_ || showing_) return;
  int64_t wait_ns = timeout.count();
  if (!begun_) return;
  if (!at_end_ && clock_.playing()) {
    if (each_frame_ || clock_.unpaced()) return;
    wait_ns = std::min(wait_ns, clock_.due_ns(pending_ ? pending_->log_time_ns : end_ns_) - monotonic_ns());
  }
  if (wait_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(wait_ns));
}

transport::LinkStats ReplayLink::stats() const {
  transport::LinkStats stats;
  stats.messages_received = messages_;
  stats.bytes_received = bytes_;
  stats.peers = peers_;
  return stats;
}

std::string ReplayLink::uri() const {
  return "file://" + playback_.reader().name();
}

TimelineState ReplayLink::timeline() const {
  TimelineState state;
  state.start_ns = start_ns_;
  state.end_ns = end_ns_;
  state.position_ns = std::min(clock_.position_ns(monotonic_ns()), end_ns_);
  if (newest_) state.sim_time_ns = players_[*newest_]->sim_time_ns();
  state.speed = clock_.speed();
  state.playing = clock_.playing() || !begun_;
  state.looping = looping_;
  state.at_end = at_end_;
  state.frames = frames();
  state.damaged_chunks = damaged_;
  state.refused_messages = playback_.refused();
  return state;
}

}  // namespace fire3dv::replay

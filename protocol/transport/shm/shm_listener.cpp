#include "protocol/transport/core/link_factories.h"

#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>

#include "base/clock.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/shm/shm_cleanup.h"
#include "protocol/transport/shm/shm_reader.h"

namespace fire3dv::transport::shm {
namespace {

// Segments of one poll: sizes double, so that an honest chain is shorter.
constexpr int kMaxSuccessors = 32;
constexpr int64_t kLookEveryNs = 20 * kMillisecondNs;
constexpr int64_t kObserverLooksEveryNs = 2 * kMillisecondNs;  // a short stream is recorded whole
constexpr int64_t kSpinNs = 20'000;
constexpr int64_t kShortestSleepNs = 50'000;
constexpr int64_t kLongestSleepNs = 200'000;
constexpr int64_t kLongestObserverSleepNs = 500'000;  // a ring has 8 slots: enough for 4 kHz

bool is_of_another_user(const std::string& path) {
  struct stat info {};
  return ::stat(path.c_str(), &info) == 0 && info.st_uid != ::geteuid();
}

void sleep_ns(int64_t ns) {
  const timespec time{ns / kSecondNs, ns % kSecondNs};
  ::nanosleep(&time, nullptr);
}

class ShmListener final : public ListenerLink {
 public:
  enum class Role { renderer, observer };  // an observer never replies: publishers do not count it
  ShmListener(std::string name, Delivery delivery, Role role = Role::renderer)
      : name_(std::move(name)), delivery_(delivery), role_(role) {}
  // A renderer often ends because its simulator was killed.
  ~ShmListener() override {
    observer_thread_.stop();
    remove_dead_segment(segment_path(name_));
  }

  // See ListenerOptions::on_arrival. A ring holds few frames, and poll() may be late: an observer reads it on
  // its own thread.
  Result<void> observe(OnArrival on_arrival);

  void poll(const std::function<void(const LinkEvent&)>& on_event) override;
  void wait(std::chrono::nanoseconds timeout) override;
  void send(PeerId peer, std::span<const std::byte> message) override;
  bool carries_images() const override { return true; }
  bool carries_input() const override { return role_ == Role::renderer; }
  bool send_image(PeerId peer, uint64_t request, std::span<const std::byte> head, size_t pixel_bytes,
                  const FillPixels& fill) override {
    return peer != 0 && peer == peer_ && reader_ && reader_->send_image(request, head, pixel_bytes, fill);
  }
  void pause_peer(PeerId peer, bool is_paused) override {
    if (peer == peer_) is_paused_ = is_paused;
  }
  void end_arrivals() override { observer_thread_.stop(); }
  LinkStats stats() const override { return counters_.snapshot(); }
  std::string uri() const override { return "shm://" + name_; }

 private:
  using OnEvent = std::function<void(const LinkEvent&)>;

  void look(const OnEvent& on_event);
  void attach(Found found, const OnEvent& on_event);
  void end_peer(const std::string& reason, const OnEvent& on_event);
  void note(const std::string& text, const OnEvent& on_event);
  // Reason to stop reading this segment; nothing while it is in use.
  std::optional<Reader::End> end_of_segment(const OnEvent& on_event);

  std::string name_;
  Delivery delivery_;
  Role role_;
  std::unique_ptr<ShmListener> observer_;
  LinkThread observer_thread_;
  std::unique_ptr<Reader> reader_;
  PeerId peer_ = 0;         // survives the replacement of a segment by its own publisher
  bool is_paused_ = false;  // state of peer_
  uint64_t publisher_id_ = 0;
  Progress progress_;
  PeerId last_peer_ = 0;
  FileId avoid_;       // a damaged segment to skip
  FileId noted_file_;  // each file and fault is reported once
  std::string noted_text_;
  int64_t next_look_ns_ = 0;
  LinkCounters counters_;
};

void ShmListener::note(const std::string& text, const OnEvent& on_event) {
  on_event({LinkEvent::Kind::note, peer_, {}, text, 0});
}

void ShmListener::end_peer(const std::string& reason, const OnEvent& on_event) {
  if (peer_ == 0) return;
  on_event({LinkEvent::Kind::disconnected, peer_, {}, reason, 0});
  peer_ = 0;
  is_paused_ = false;
  publisher_id_ = 0;
  progress_ = {};
  counters_.peers.set(0);
}

void ShmListener::look(const OnEvent& on_event) {
  FileId seen;
  auto found = find_segment(name_, seen);
  if (!found) {
    if (seen != noted_file_ || found.error().message != noted_text_) {
      counters_.reject(is_of_another_user(segment_path(name_)) ? Cause::system : Cause::malformed);
      noted_file_ = seen;
      noted_text_ = found.error().message;
      note(noted_text_, on_event);
    }
    return;
  }
  if (!found->segment.fd && found->id != FileId()) remove_dead_segment(segment_path(name_));
  if (!found->segment.fd || found->id == avoid_) return;
  attach(std::move(*found), on_event);
}

void ShmListener::attach(Found found, const OnEvent& on_event) {
  const uint64_t publisher_id = found.segment.geometry.publisher_id;
  const bool same_publisher = peer_ != 0 && publisher_id == publisher_id_;
  if (!same_publisher) end_peer("another publisher took over", on_event);
  reader_ = std::make_unique<Reader>(std::move(found), delivery_, same_publisher ? &progress_ : nullptr,
                                     counters_, role_ == Role::renderer);
  noted_file_ = {};
  noted_text_.clear();
  if (!same_publisher) {
    peer_ = ++last_peer_;
    publisher_id_ = publisher_id;
    counters_.peers.set(1);
    on_event({LinkEvent::Kind::connected, peer_, {}, {}, 0});
  }
  if (role_ == Role::renderer && !reader_->can_reply())
    note(uri() + ": all " + std::to_string(kReaderCount) +
             " reader slots are taken; poses come, but the simulator hears no reply from this reader",
         on_event);
}

std::optional<Reader::End> ShmListener::end_of_segment(const OnEvent& on_event) {
  if (auto end = reader_->end_by_state()) return end;
  const int64_t now = monotonic_ns();
  if (now < next_look_ns_) return {};
  next_look_ns_ = now + kLookEveryNs;
  const bool knew = reader_->has_lost_name();
  const std::optional<Reader::End> end = reader_->end_by_file(segment_path(name_));
  if (reader_->has_lost_name() && !knew)
    note(uri() +
             ": its file was removed from /dev/shm, by rm or at a logout (RemoveIPC=yes of logind.conf); the "
             "simulator makes a new one, or must be restarted if it is of an older version",
         on_event);
  return end;
}

void ShmListener::poll(const OnEvent& on_event) {
  if (is_paused_) return;
  // The successor of an ended segment may already exist, and may have a successor itself: a publisher grows
  // in steps. Between segments an image cannot be sent, and would be lost.
  for (int round = 0; round < kMaxSuccessors; ++round) {
    if (!reader_) {
      const int64_t now = monotonic_ns();
      if (round == 0 && now < next_look_ns_) return;
      next_look_ns_ = now + (role_ == Role::renderer ? kLookEveryNs : kObserverLooksEveryNs);
      look(on_event);
      if (!reader_) {
        end_peer("the publisher is gone", on_event);
        return;
      }
    }
    // Checked before reading the rings, so that messages published before the end are not lost.
    const std::optional<Reader::End> end = end_of_segment(on_event);
    const auto on_message = [&](LinkEvent::Kind kind, std::span<const std::byte> message,
                                uint64_t overtaken) {
      on_event({kind, peer_, message, {}, 0, overtaken});
    };
    const bool sound = reader_->drain(progress_, on_message);
    if (!sound) {
      avoid_ = reader_->id();
      counters_.reject(Cause::malformed);
      reader_.reset();
      note(uri() + ": the segment is damaged; restart the simulator", on_event);
      end_peer("the segment is damaged", on_event);
      return;
    }
    if (!end) return;
    reader_.reset();
    if (*end == Reader::End::closed) end_peer("the publisher closed the link", on_event);
    if (*end == Reader::End::dead) {
      remove_dead_segment(segment_path(name_));
      end_peer("the publisher died", on_event);
    }
    // Replaced: the next segment shows whether the same publisher grew it, or another took over.
  }
}

void ShmListener::wait(std::chrono::nanoseconds timeout) {
  const int64_t start = monotonic_ns();
  const int64_t until = start + std::max<int64_t>(timeout.count(), 0);
  int64_t sleep = kShortestSleepNs;
  const int64_t longest = role_ == Role::renderer ? kLongestSleepNs : kLongestObserverSleepNs;
  for (int64_t now = start; now < until; now = monotonic_ns()) {
    if (reader_ ? reader_->has_unread() || now >= next_look_ns_ : now >= next_look_ns_) return;
    if (reader_ && role_ == Role::renderer && now - start < kSpinNs) continue;
    const int64_t next = reader_ ? now + sleep : next_look_ns_;
    sleep_ns(std::min(next, until) - now);
    sleep = std::min(sleep * 2, longest);
  }
}

Result<void> ShmListener::observe(OnArrival on_arrival) {
  observer_ = std::make_unique<ShmListener>(name_, Delivery::all, Role::observer);
  return observer_thread_.start(uri(), [this, on_arrival = std::move(on_arrival)] {
    const OnEvent forward = [&](const LinkEvent& event) {
      if (event.kind != LinkEvent::Kind::connected && event.kind != LinkEvent::Kind::note) on_arrival(event);
    };
    for (bool is_last = false; !is_last;) {
      is_last = observer_thread_.stopping();  // read before the ring: what was published before counts
      try {
        if (!is_last) observer_->wait(std::chrono::nanoseconds(kLookEveryNs));
        observer_->poll(forward);
      } catch (const std::exception&) {  // out of memory: the message is lost, and later ones may fit again
        counters_.reject(Cause::no_memory);
      }
    }
  });
}

void ShmListener::send(PeerId peer, std::span<const std::byte> message) {
  if (peer == 0 || peer != peer_ || !reader_) return;
  if (!reader_->reply(message)) {
    counters_.reject(Cause::full);  // the simulator does not read replies
    return;
  }
  counters_.messages_sent.add();
  counters_.bytes_sent.add(message.size());
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const std::string& name, const ListenerOptions& options) {
  remove_dead_segments();
  auto listener = std::make_unique<ShmListener>(name, options.delivery);
  if (options.on_arrival) {
    if (auto started = listener->observe(options.on_arrival); !started) return started.error();
  }
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::shm

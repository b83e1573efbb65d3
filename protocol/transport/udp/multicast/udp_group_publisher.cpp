#include "protocol/transport/core/link_factories.h"

#include <algorithm>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/udp/multicast/udp_group.h"
#include "protocol/transport/udp/udp_group_socket.h"
#include "protocol/transport/udp/udp_poses.h"

namespace fire3dv::transport::udp {
namespace {

// Minimum duration of a round: upper bound of a joiner's wait for a short carousel.
constexpr int64_t kRoundNs = kSecondNs;
// About 30 Mbit/s with default datagrams: the carousel runs permanently beside the poses.
constexpr int kGroupBurst = 16;
constexpr int64_t kGroupBurstEveryNs = 5 * kMillisecondNs;
constexpr int64_t kGroupIdleTickNs = 50 * kMillisecondNs;

// The simulator's thread sends pose datagrams itself; the link's thread sends the carousel and repeats the
// newest frame. All sends are non-blocking, so that the lock is never held across a wait.
class GroupPublisher final : public NetworkPublisher {
 public:
  GroupPublisher(const Uri& uri, const Address& group, Carousel carousel)
      : NetworkPublisher(uri),
        group_(group),
        datagram_bytes_(uri.mtu != 0 ? uri.mtu : kDatagramBytes),
        session_(random_id(), monotonic_ns(), nullptr, datagram_bytes_),
        carousel_(std::move(carousel)),
        poses_(datagram_bytes_, ParityRate(uri.parity_percent, false)) {}
  ~GroupPublisher() override { thread_.stop(); }

  size_t max_pose_message_bytes() const override { return pose_bytes_of(datagram_bytes_); }
  Result<void> set_description(std::span<const std::byte> message) override;
  Result<void> put_state(uint64_t key, SharedBytes message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  LinkStats stats() const override;

 private:
  bool visit(const Address& address) override;
  void serve();

  // Require mutex_.
  int64_t tick(int64_t now_ns);
  void send(Type type, std::span<const std::byte> head, std::span<const std::byte> data);
  void count(const PoseSender::Drops& drops) {
    counters_.poses_dropped.add(drops.messages);
    counters_.frames_dropped.add(drops.frames);
  }

  const Address group_;
  const size_t datagram_bytes_;

  // Guarded by mutex_.
  int fd_ = -1;
  Session session_;  // id and datagram counter; plaintext, send only
  Carousel carousel_;
  PoseSender poses_;
  int64_t next_round_ns_ = 0;
  int64_t next_burst_ns_ = 0;
};

// --- the simulator's thread

Result<void> GroupPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxControlBytes)
    return Error{uri_text(uri_) +
                 ": the description is larger than 64 MiB; use tcp:// or describe fewer nodes"};
  if (is_inherited()) return inherited_error();
  ControlSender::Prepared prepared = ControlSender::prepare(message);
  const std::lock_guard lock(mutex_);
  carousel_.describe(std::move(prepared));
  count(poses_.start_description());
  next_round_ns_ = monotonic_ns() + kRoundNs;
  thread_.wake();
  return {};
}

Result<void> GroupPublisher::put_state(uint64_t key, SharedBytes message) {
  if (is_inherited()) return inherited_error();
  ControlSender::Prepared prepared = ControlSender::prepare(*message);
  const std::lock_guard lock(mutex_);
  bool dropped = false;
  if (!carousel_.put(key, std::move(prepared), &dropped))
    return Error{
        uri_text(uri_) +
        ": a group repeats at most 4096 scene edits of 64 MiB together; publish to each renderer instead"};
  if (dropped) counters_.reject(Cause::lapped);
  thread_.wake();
  return {};
}

bool GroupPublisher::publish(const wire::MessagePieces& message, bool last_part) noexcept {
  counters_.messages_sent.add();
  if (is_inherited()) {  // listeners would drop the parent's datagrams of the same counters
    count({1, 1});
    return false;
  }
  try {
    const std::lock_guard lock(mutex_);
    PoseSender::Drops drops;
    const auto outcome =
        poses_.publish(fd_, fd_ >= 0 ? &session_ : nullptr, message, last_part, monotonic_ns(), drops);
    count(drops);
    return outcome != PoseSender::Outcome::dropped;
  } catch (const std::exception&) {  // out of memory
    count({1, 1});
    return false;
  }
}

void GroupPublisher::send_control(std::span<const std::byte> message) noexcept {
  if (is_inherited()) return;
  try {
    if (message.size() > kMaxControlBytes) return counters_.reject(Cause::oversize);
    ControlSender::Prepared prepared = ControlSender::prepare(message);
    const std::lock_guard lock(mutex_);
    if (!carousel_.add(std::move(prepared))) counters_.reject(Cause::lapped);
    thread_.wake();
  } catch (const std::exception&) {
    counters_.reject(Cause::no_memory);
  }
}

LinkStats GroupPublisher::stats() const {
  LinkStats stats = counters_.snapshot();
  if (is_inherited()) return stats;
  const std::lock_guard lock(mutex_);
  stats.bytes_sent += poses_.bytes_sent();
  return stats;  // the number of listeners is unknown
}

// --- the link's thread

bool GroupPublisher::visit(const Address&) {
  const Result<UniqueFd> fd = open_group_sender(uri_, group_);
  if (!fd) {
    set_problem(fd.error().message);
    return false;
  }
  set_problem({});
  {
    const std::lock_guard lock(mutex_);
    fd_ = fd->get();
    carousel_.start_round();
    next_round_ns_ = monotonic_ns() + kRoundNs;
  }
  // Clears the descriptor on every path out of this function.
  struct Leave {
    GroupPublisher& self;
    ~Leave() {
      const std::lock_guard lock(self.mutex_);
      self.fd_ = -1;
    }
  } leave{*this};
  serve();
  return true;
}

void GroupPublisher::serve() {
  while (!thread_.stopping()) {
    int64_t wait_ns;
    {
      const std::lock_guard lock(mutex_);
      wait_ns = tick(monotonic_ns());
    }
    thread_.wait(-1, 0, wait_ns);
  }
  const std::lock_guard lock(mutex_);
  tick(monotonic_ns());  // sends a queued Goodbye message
  send(Type::bye, {}, {});
}

// Sends due datagrams and returns the time until the next call.
int64_t GroupPublisher::tick(int64_t now_ns) {
  if (carousel_.consume_renumbering()) {
    send(Type::bye, {}, {});
    session_ = Session(random_id(), now_ns, nullptr, datagram_bytes_);
    poses_.start_session();
  }
  if (now_ns >= next_round_ns_ && carousel_.round_is_over()) {
    carousel_.start_round();
    next_round_ns_ = now_ns + kRoundNs;
  }
  if (now_ns >= next_burst_ns_) {
    if (carousel_.consume_offer_change()) {
      std::byte offer[kGroupOfferBytes];
      write_group_offer(offer, carousel_.offer());
      send(Type::group, offer, {});
    }
    for (int i = 0; i < kGroupBurst; ++i) {
      const auto fragment = carousel_.next();
      if (!fragment) break;
      std::byte head[kFragmentHeaderBytes];
      write_fragment_header(head, fragment->header);
      send(Type::fragment, head, fragment->data);
    }
    next_burst_ns_ = now_ns + kGroupBurstEveryNs;
  }
  poses_.emit_due(fd_, session_, now_ns);
  int64_t next_ns =
      carousel_.round_is_over() ? std::min(next_round_ns_, now_ns + kGroupIdleTickNs) : next_burst_ns_;
  if (const auto due_ns = poses_.due_at_ns()) next_ns = std::min(next_ns, *due_ns);
  return std::max(next_ns - now_ns, kMillisecondNs);
}

// A datagram that the socket rejects is repeated later, like a lost one.
void GroupPublisher::send(Type type, std::span<const std::byte> head, std::span<const std::byte> data) {
  Session::Buffer datagram;
  session_.start(datagram, type);
  std::byte* end = std::copy(head.begin(), head.end(), datagram.data() + kHeaderBytes);
  end = std::copy(data.begin(), data.end(), end);
  const std::span<const std::byte> whole =
      session_.finish(datagram, static_cast<size_t>(end - datagram.data()));
  if (::send(fd_, whole.data(), whole.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0)
    counters_.bytes_sent.add(whole.size());
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_group_publisher(const Uri& uri, const Address& group,
                                                            const PublisherOptions& options,
                                                            uint32_t max_number) {
  if (!options.key_file.empty())
    return Error{uri_text(uri) +
                 ": datagrams to a group cannot be sealed; leave the key away, or publish to one renderer"};
  auto publisher = std::make_unique<GroupPublisher>(
      uri, group, Carousel(uri.mtu != 0 ? uri.mtu : kDatagramBytes, max_number));
  if (auto started = publisher->start(); !started) return started.error();
  return std::unique_ptr<PublisherLink>(std::move(publisher));
}

}  // namespace fire3dv::transport::udp

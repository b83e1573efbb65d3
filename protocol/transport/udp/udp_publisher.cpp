#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/clock.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/udp/udp_control.h"
#include "protocol/transport/udp/udp_group_socket.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_path_probe.h"
#include "protocol/transport/udp/udp_poses.h"
#include "protocol/transport/udp/udp_session_opener.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kLostAfterNs = 3500 * kMillisecondNs;
// Resets and ICMP errors are not authenticated. After one, a sealed session probes the listener by pings and
// ends only if no sealed datagram arrives within the timeout.
constexpr int64_t kProbeTimeoutNs = kSecondNs;
constexpr int64_t kProbePingNs = 200 * kMillisecondNs;
constexpr int64_t kPublisherTickNs = 10 * kMillisecondNs;
constexpr int64_t kIdleTickNs = 50 * kMillisecondNs;
constexpr size_t kMaxQueuedBytes = 16 << 20;

// The simulator's thread sends pose datagrams itself; the link's thread connects, repeats and receives. All
// sends are non-blocking, so that the lock is never held across a wait.
class UdpPublisher final : public NetworkPublisher {
 public:
  UdpPublisher(const Uri& uri, std::shared_ptr<const PreSharedKey> key)
      : NetworkPublisher(uri),
        key_(std::move(key)),
        datagram_bytes_(uri.mtu != 0 ? uri.mtu : kDatagramBytes),
        poses_(datagram_bytes_, ParityRate(uri.parity_percent)) {}
  ~UdpPublisher() override { thread_.stop(); }

  size_t max_pose_message_bytes() const override { return pose_bytes_of(datagram_bytes_); }
  Result<void> set_description(std::span<const std::byte> message) override;
  Result<void> put_state(uint64_t key, SharedBytes message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  bool takes_partial_frames() const override { return true; }
  bool publish_partial(const wire::MessagePieces& partial,
                       std::span<const wire::MessagePieces> whole) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  LinkStats stats() const override;

 private:
  // The link's thread.
  bool visit(const Address& address) override;
  void serve(int fd, std::unique_ptr<Session> session);
  // Performs all due work and sets the time of the next. Returns false if the session is over.
  bool tick(int fd, int64_t now_ns, int64_t& next_ns);
  void receive(int fd);
  void start_probe(int64_t now_ns);
  void handle(std::span<std::byte> datagram);
  void handle_sealed(std::span<std::byte> datagram);
  // Processes the payload of a datagram, or counts why it is dropped.
  void handle_payload(Session::Received received, Type type, std::span<const std::byte> payload,
                      int64_t now_ns);

  // Require mutex_.
  bool queue_description();
  void check_described();
  void ping(int fd, int64_t now_ns);
  bool shorten_datagrams();
  void emit(int fd, int64_t now_ns);
  template <typename Send>
  bool publish_by(Send send) noexcept;
  void count(const PoseSender::Drops& drops) {
    counters_.poses_dropped.add(drops.messages);
    counters_.frames_dropped.add(drops.frames);
  }
  size_t max_queued_bytes() const {
    return kMaxQueuedBytes + (description_.bytes ? description_.bytes->size() : 0);
  }

  const std::shared_ptr<const PreSharedKey> key_;  // null: unsealed
  // Changes on the link's thread, under mutex_: shorter on a path that does not carry longer ones.
  std::atomic<size_t> datagram_bytes_;

  // Guarded by mutex_.
  int64_t next_probe_ns_ = 0;
  PathProbe path_;
  uint64_t last_have_ = 0;
  int fd_ = -1;
  std::unique_ptr<Session> session_;
  bool described_ = false;  // the listener has the newest description: poses may follow
  uint32_t description_number_ = 0;
  bool lost_ = false;             // the session is to be given up
  int64_t probing_since_ns_ = 0;  // unauthenticated report that the session is unknown; 0: none
  PoseSender poses_;
  ControlSender::Prepared description_;  // bytes null: none yet
  KeyedStates states_;                   // as records
  StateSender state_sender_;
};

// --- the simulator's thread

bool UdpPublisher::queue_description() {
  described_ = description_.bytes == nullptr;
  if (described_) return true;
  const auto number = session_->sender().push(description_, max_queued_bytes());
  description_number_ = number.value_or(0);
  return number.has_value();
}

Result<void> UdpPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxControlBytes)
    return Error{uri_text(uri_) +
                 ": the description is larger than 64 MiB; use tcp:// or describe fewer nodes"};
  if (is_inherited()) return inherited_error();
  ControlSender::Prepared prepared = ControlSender::prepare(message);
  const std::lock_guard lock(mutex_);
  std::swap(description_, prepared);  // the old one is freed after the lock is released
  count(poses_.start_description());
  states_ = states_.cleared();
  state_sender_.discard(states_);
  described_ = false;
  // If the queue is full, starts a new session with the newest description only.
  if (session_ && !queue_description()) lost_ = true;
  thread_.wake();
  return {};
}

Result<void> UdpPublisher::put_state(uint64_t key, SharedBytes message) {
  if (message->size() > kMaxStateBytes)
    return Error{uri_text(uri_) + ": a scene edit is larger than 64 MiB; name a file or use tcp://"};
  if (message->size() < kLeastStateBytes)
    return Error{uri_text(uri_) + ": a scene edit of " + std::to_string(message->size()) +
                 " bytes is not a message; pass the whole encoded edit"};
  if (is_inherited()) return inherited_error();
  KeyedState record = make_record(*message);
  const std::lock_guard lock(mutex_);
  states_.put(key, std::move(record.message), record.hash);
  thread_.wake();
  return {};
}

bool UdpPublisher::publish(const wire::MessagePieces& message, bool last_part) noexcept {
  return publish_by([&](Session* ready, PoseSender::Drops& drops) {
    return poses_.publish(fd_, ready, message, last_part, monotonic_ns(), drops);
  });
}

bool UdpPublisher::publish_partial(const wire::MessagePieces& partial,
                                   std::span<const wire::MessagePieces> whole) noexcept {
  return publish_by([&](Session* ready, PoseSender::Drops& drops) {
    return poses_.publish_partial(fd_, ready, partial, whole, monotonic_ns(), drops);
  });
}

template <typename Send>
bool UdpPublisher::publish_by(Send send) noexcept {
  counters_.messages_sent.add();
  // A forked child would reuse the parent's keys and record numbers for other bytes.
  if (is_inherited()) {
    count({1, 1});
    return false;
  }
  try {
    const std::lock_guard lock(mutex_);
    PoseSender::Drops drops;
    Session* ready = session_ && described_ ? session_.get() : nullptr;
    const auto outcome = send(ready, drops);
    count(drops);
    if (outcome == PoseSender::Outcome::refused) {
      start_probe(monotonic_ns());
      thread_.wake();
    }
    return outcome != PoseSender::Outcome::dropped;
  } catch (const std::exception&) {  // out of memory
    count({1, 1});
    return false;
  }
}

void UdpPublisher::send_control(std::span<const std::byte> message) noexcept {
  if (is_inherited()) return;
  try {
    ControlSender::Prepared prepared = ControlSender::prepare(message);
    const std::lock_guard lock(mutex_);
    if (!session_) return;
    if (!session_->sender().push(std::move(prepared), max_queued_bytes())) {
      counters_.reject(Cause::unread);
      lost_ = true;  // a control message is never dropped within a session
    }
    thread_.wake();
  } catch (const std::exception&) {
    counters_.reject(Cause::no_memory);
  }
}

LinkStats UdpPublisher::stats() const {
  LinkStats stats = counters_.snapshot();
  if (is_inherited()) return stats;
  const std::lock_guard lock(mutex_);
  stats.bytes_sent += poses_.bytes_sent();
  stats.peers = session_ ? 1 : 0;
  return stats;
}

// --- the link's thread

bool UdpPublisher::visit(const Address& address) {
  const UniqueFd fd(::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return false;
  const int buffer = 4 << 20;
  ::setsockopt(fd.get(), SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  if (::connect(fd.get(), address.get(), address.length) != 0) return false;
  SessionOpener opener(fd.get(), uri_, key_.get(), datagram_bytes_, thread_, counters_);
  auto session = opener.open();
  if (!session) {
    if (!opener.refusal().empty()) set_problem(opener.refusal());
    return false;
  }
  set_problem({});
  serve(fd.get(), std::move(session));
  return true;
}

void UdpPublisher::serve(int fd, std::unique_ptr<Session> session) {
  // Clears the descriptor on every path out of this function.
  struct Leave {
    UdpPublisher& self;
    ~Leave() {
      const std::lock_guard lock(self.mutex_);
      self.fd_ = -1;
      self.session_.reset();
      self.described_ = false;
    }
  } leave{*this};
  {
    const std::lock_guard lock(mutex_);
    session_ = std::move(session);
    fd_ = fd;
    lost_ = false;
    probing_since_ns_ = 0;
    poses_.start_session();
    state_sender_.start_session();
    queue_description();
    path_.start_session(monotonic_ns());
    last_have_ = 0;
  }
  while (!thread_.stopping()) {
    const int64_t now = monotonic_ns();
    int64_t next = now;
    if (!tick(fd, now, next)) return;
    if (thread_.wait(fd, POLLIN, next - now) != 0) receive(fd);
  }
  // Orderly end: sends the queued datagrams once, then bye.
  const std::lock_guard lock(mutex_);
  emit(fd, monotonic_ns());
  session_->emit_bare(Type::bye, [fd](auto datagram) { ::send(fd, datagram.data(), datagram.size(), 0); });
}

bool UdpPublisher::tick(int fd, int64_t now_ns, int64_t& next_ns) {
  const std::lock_guard lock(mutex_);
  const bool probe_failed = probing_since_ns_ != 0 && now_ns - probing_since_ns_ > kProbeTimeoutNs;
  if (lost_ || probe_failed || session_->broken() || now_ns - session_->last_received_ns() > kLostAfterNs)
    return false;
  if (path_.has_black_hole() && shorten_datagrams()) return false;
  check_described();
  emit(fd, now_ns);
  ping(fd, now_ns);
  const bool idle = session_->sender().idle() && session_->state_sender().idle();
  next_ns = now_ns + (idle ? kIdleTickNs : kPublisherTickNs);
  if (const auto due = described_ ? poses_.due_at_ns() : std::nullopt)
    next_ns = std::clamp(*due, now_ns + kMillisecondNs, next_ns);
  return true;
}

void UdpPublisher::ping(int fd, int64_t now_ns) {
  const auto send_ping = [fd](auto datagram) { ::send(fd, datagram.data(), datagram.size(), 0); };
  PathProbe::Ping due = path_.due(now_ns);
  if (due == PathProbe::Ping::none && probing_since_ns_ != 0 && now_ns >= next_probe_ns_) {
    next_probe_ns_ = now_ns + kProbePingNs;
    due = PathProbe::Ping::bare;
  }
  if (due == PathProbe::Ping::whole_length) session_->emit_long_ping(send_ping);
  if (due == PathProbe::Ping::bare) session_->emit_bare(Type::ping, send_ping);
}

// Short datagrams arrive and long ones do not. Returns true if shorter ones are to be tried, in a new
// session.
bool UdpPublisher::shorten_datagrams() {
  const auto shorter = shorter_datagram_bytes(datagram_bytes_);
  if (!shorter) {
    set_problem_locked(uri_text(uri_) + ": datagrams of " + std::to_string(datagram_bytes_) +
                       " bytes are lost on the way; use tcp:// or tls://");
    path_.start_session(monotonic_ns());
    return false;
  }
  set_problem_locked(uri_text(uri_) + ": datagrams of " + std::to_string(datagram_bytes_) +
                     " bytes are lost on the way; going on with ?mtu=" + std::to_string(*shorter));
  datagram_bytes_ = *shorter;
  count(poses_.set_datagram_bytes(*shorter));
  return true;
}

void UdpPublisher::check_described() {
  described_ = described_ || session_->sender().last_acknowledged() >= description_number_;
}

void UdpPublisher::emit(int fd, int64_t now_ns) {
  if (described_) state_sender_.feed(session_->state_sender(), states_);
  session_->emit_due(now_ns, [&](std::span<const std::byte> datagram) {
    // A datagram that the socket rejects is repeated later, like a lost one.
    if (::send(fd, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0)
      counters_.bytes_sent.add(datagram.size());
  });
  if (described_) poses_.emit_due(fd, *session_, now_ns);
}

void UdpPublisher::receive(int fd) {
  for (int i = 0; i < 64; ++i) {
    std::byte buffer[kMaxDatagramBytes + 1];
    const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
    const std::lock_guard lock(mutex_);
    if (got < 0) {
      if (errno == ECONNREFUSED) start_probe(monotonic_ns());
      return;
    }
    counters_.bytes_received.add(static_cast<uint64_t>(got));
    handle({buffer, static_cast<size_t>(got)});
    if (lost_) return;
  }
}

// Handles an unauthenticated end of the session (reset, ICMP error). Requires mutex_.
void UdpPublisher::start_probe(int64_t now_ns) {
  if (!session_->sealed()) {
    lost_ = true;
  } else if (probing_since_ns_ == 0) {
    probing_since_ns_ = next_probe_ns_ = now_ns;
  }
}

void UdpPublisher::handle(std::span<std::byte> datagram) {
  Header header;
  if (!read_header(datagram, header)) {
    if (session_->sealed()) return handle_sealed(datagram);
    return counters_.reject(Cause::malformed);
  }
  if (header.version != kTransportVersion) return counters_.reject(Cause::version);
  const int64_t now = monotonic_ns();
  // The reset of a sealed session carries no id, since the listener could not read one.
  if (header.type == Type::reset && (session_->sealed() || header.session == session_->id()))
    return start_probe(now);
  if (session_->sealed() || header.session != session_->id()) return counters_.reject(Cause::unknown_session);
  std::span<const std::byte> payload;
  const auto received = session_->receive(header, datagram, now, payload);
  handle_payload(received, header.type, payload, now);
}

void UdpPublisher::handle_sealed(std::span<std::byte> datagram) {
  const RecordDatagram about = inspect_records(datagram);
  // A repetition of the listener's last flight.
  if (about.kind == RecordDatagram::Kind::handshake) return counters_.reject(Cause::replayed);
  if (about.kind != RecordDatagram::Kind::data) return counters_.reject(Cause::malformed);
  const int64_t now = monotonic_ns();
  Type type{};
  std::span<const std::byte> payload;
  const auto received = session_->open(about, datagram, now, type, payload);
  if (received == Session::Received::payload && type == Type::accept) return;  // a repeated answer
  handle_payload(received, type, payload, now);
}

void UdpPublisher::handle_payload(Session::Received received, Type type, std::span<const std::byte> payload,
                                  int64_t now_ns) {
  switch (received) {
    case Session::Received::repeated:
      return counters_.reject(Cause::replayed);
    case Session::Received::forged:
      return counters_.reject(Cause::bad_key);
    case Session::Received::too_long:
      return counters_.reject(Cause::oversize);
    case Session::Received::payload:
      break;
  }
  probing_since_ns_ = 0;
  if (type == Type::bye) {
    lost_ = true;
    return;
  }
  if (type == Type::have) {
    const auto frame = read_number(payload);
    if (frame && *frame > last_have_) {
      last_have_ = *frame;
      const auto shorter = shorter_datagram_bytes(datagram_bytes_);
      if (shorter && poses_.longest_payload() > *shorter) path_.on_long_datagram();
    }
    if (frame) poses_.acknowledge(*frame);
    if (const auto receipt = read_receipt(payload)) poses_.report(*receipt, now_ns);
    return;
  }
  if (type == Type::pong) path_.on_pong();
  switch (session_->control(type, payload, kMaxReplyBytes, now_ns)) {
    case ControlReceiver::Outcome::complete:
      if (type == Type::fragment)
        queue_reply(session_->receiver().take());
      else
        session_->state_receiver().take();  // listeners send no states
      break;
    case ControlReceiver::Outcome::corrupt:
      lost_ = true;
      [[fallthrough]];
    case ControlReceiver::Outcome::ignored:
      counters_.reject(Cause::malformed);
      break;
    case ControlReceiver::Outcome::accepted:
      break;
  }
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options) {
  if (const auto group = group_of(uri)) return make_group_publisher(uri, *group, options);
  if (auto sound = refuse_group_options(uri); !sound) return sound.error();
  auto key = PreSharedKey::from_file(options.key_file, uri);
  if (!key) return key.error();
  auto publisher = std::make_unique<UdpPublisher>(uri, std::move(*key));
  if (auto started = publisher->start(); !started) return started.error();
  return std::unique_ptr<PublisherLink>(std::move(publisher));
}

}  // namespace fire3dv::transport::udp

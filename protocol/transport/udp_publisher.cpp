#include "protocol/transport/udp_publisher.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "protocol/transport/address.h"
#include "protocol/transport/clock.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/random.h"
#include "protocol/transport/udp_handshake.h"
#include "protocol/transport/udp_pose_sender.h"
#include "protocol/transport/waker.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kFirstBackoffNs = 10 * kMillisecondNs;
constexpr int64_t kLongestBackoffNs = kSecondNs;
constexpr int64_t kTryAnAddressForNs = 3 * kSecondNs;
constexpr int64_t kKeepaliveNs = kSecondNs;
constexpr int64_t kLostAfterNs = 3500 * kMillisecondNs;
constexpr int kTickMs = 10;
constexpr size_t kMostWaitingBytes = 16 << 20;
constexpr size_t kMostUnreadReplies = 1024;

// The simulator's thread sends pose datagrams itself; a thread of the link greets, repeats and receives.
// Every send is non-blocking, so that the lock is never held across a wait.
class UdpPublisher final : public PublisherLink {
 public:
  explicit UdpPublisher(Uri uri) : uri_(std::move(uri)) {}
  Result<void> start();
  ~UdpPublisher() override;

  size_t max_pose_message_bytes() const override { return kMaxPoseBytes; }
  Result<void> set_description(std::span<const std::byte> message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  bool poll(std::vector<std::byte>& message) override;
  LinkStats stats() const override;

 private:
  // The link's thread.
  void run();
  void try_address(const Address& address);
  enum class Greeting { accepted, refused, nobody, silent };
  Greeting greet(int fd, uint64_t& session);
  void serve(int fd, uint64_t session);
  void receive(int fd, bool& lost);
  void handle(std::span<const std::byte> datagram, bool& lost);
  void emit_due(int fd, int64_t now_ns);
  void check_described(int fd);
  void pause(int64_t ns);
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }

  // With the lock held.
  bool queue_description();
  Session* ready_session() { return session_ && described_ ? &*session_ : nullptr; }
  size_t most_waiting_bytes() const { return kMostWaitingBytes + description_.size(); }

  Uri uri_;
  Waker waker_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  LinkCounters counters_;
  int64_t backoff_ns_ = kFirstBackoffNs;

  mutable std::mutex mutex_;  // guards all that follows
  int fd_ = -1;
  std::optional<Session> session_;
  bool described_ = false;  // the listener has the newest description: poses may follow
  uint32_t description_number_ = 0;
  bool lost_ = false;  // the session is to be given up
  PoseSender poses_;
  wire::Bytes description_;
  std::deque<std::vector<std::byte>> replies_;
};

Result<void> UdpPublisher::start() {
  if (!waker_) return Error{uri_text(uri_) + ": out of file descriptors; close some or raise the limit"};
  thread_ = std::thread([this] { run(); });
  return {};
}

UdpPublisher::~UdpPublisher() {
  stop_.store(true, std::memory_order_relaxed);
  waker_.wake();
  if (thread_.joinable()) thread_.join();
}

// --- the simulator's thread
// ------------------------------------------------------------------------------------------

bool UdpPublisher::queue_description() {
  described_ = description_.empty();
  if (described_) return true;
  const auto number = session_->sender().push(description_, most_waiting_bytes());
  description_number_ = number.value_or(0);
  return number.has_value();
}

Result<void> UdpPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxControlBytes)
    return Error{uri_text(uri_) +
                 ": the description is larger than 64 MiB; use tcp:// or describe fewer nodes"};
  const std::lock_guard lock(mutex_);
  description_.assign(message.begin(), message.end());
  counters_.poses_dropped.add(poses_.drop_kept());  // they belong to the description before
  described_ = false;
  // When too much waits, a new session carries the newest description alone.
  if (session_ && !queue_description()) lost_ = true;
  waker_.wake();
  return {};
}

bool UdpPublisher::publish(const wire::MessagePieces& message, bool last_part) noexcept {
  counters_.messages_sent.add();
  try {
    const std::lock_guard lock(mutex_);
    uint64_t overtaken = 0;
    const auto outcome = poses_.publish(fd_, ready_session(), message, last_part, overtaken);
    counters_.poses_dropped.add(overtaken);
    if (outcome == PoseSender::Outcome::sent || outcome == PoseSender::Outcome::kept) return true;
    if (outcome == PoseSender::Outcome::refused) {
      lost_ = true;
      waker_.wake();
    }
  } catch (const std::exception&) {  // no memory to keep the frame
  }
  counters_.poses_dropped.add();
  return false;
}

void UdpPublisher::send_control(std::span<const std::byte> message) noexcept {
  try {
    const std::lock_guard lock(mutex_);
    if (!session_) return;
    if (!session_->sender().push(message, most_waiting_bytes())) {
      counters_.rejected.add();
      lost_ = true;  // a control message is not dropped while the rest goes on
    }
    waker_.wake();
  } catch (const std::exception&) {
    counters_.rejected.add();
  }
}

bool UdpPublisher::poll(std::vector<std::byte>& message) {
  const std::lock_guard lock(mutex_);
  if (replies_.empty()) return false;
  message.swap(replies_.front());
  replies_.pop_front();
  return true;
}

LinkStats UdpPublisher::stats() const {
  LinkStats stats = counters_.snapshot();
  const std::lock_guard lock(mutex_);
  stats.bytes_sent += poses_.bytes_sent();
  stats.peers = session_ ? 1 : 0;
  return stats;
}

// --- the link's thread
// -----------------------------------------------------------------------------------------------

void UdpPublisher::run() {
  while (!stopping()) {
    try {
      const Lookup lookup(uri_);
      while (!lookup.done() && !stopping()) waker_.wait(-1, 0, 1);
      if (stopping()) return;
      const std::vector<Address> addresses = lookup.addresses();
      for (const Address& address : addresses)
        if (!stopping()) try_address(address);
      if (addresses.empty()) pause(kLongestBackoffNs);
    } catch (const std::exception&) {  // no memory: try again later, like after any other failure
      pause(kLongestBackoffNs);
    }
  }
}

void UdpPublisher::pause(int64_t ns) {
  const int64_t until = monotonic_ns() + ns;
  for (int64_t now = monotonic_ns(); now < until && !stopping(); now = monotonic_ns())
    waker_.wait(-1, 0, static_cast<int>((until - now) / kMillisecondNs) + 1);
}

void UdpPublisher::try_address(const Address& address) {
  const UniqueFd fd(::socket(address.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int buffer = 4 << 20;
  if (fd) ::setsockopt(fd.get(), SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  if (fd) ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  if (fd && ::connect(fd.get(), address.get(), address.length) == 0) {
    uint64_t session = 0;
    const Greeting greeting = greet(fd.get(), session);
    if (greeting == Greeting::accepted) {
      backoff_ns_ = kFirstBackoffNs;
      serve(fd.get(), session);
      return;  // its loss may be the listener's restart: greet again at once
    }
    if (greeting == Greeting::refused) counters_.rejected.add();
  }
  pause(backoff_ns_);
  backoff_ns_ = std::min(backoff_ns_ * 2, kLongestBackoffNs);
}

UdpPublisher::Greeting UdpPublisher::greet(int fd, uint64_t& session) {
  const uint64_t nonce = random_id();
  uint64_t cookie = 0;
  int64_t wait_ns = kFirstBackoffNs;
  const int64_t until = monotonic_ns() + kTryAnAddressForNs;
  while (!stopping() && monotonic_ns() < until) {
    const Hello hello = write_hello(nonce, cookie);
    if (::send(fd, hello.data(), hello.size(), MSG_NOSIGNAL) < 0 && errno == ECONNREFUSED)
      return Greeting::nobody;
    const int64_t repeat_at = monotonic_ns() + wait_ns;
    wait_ns = std::min(wait_ns * 2, kLongestBackoffNs);
    bool answered = false;
    for (int64_t now = monotonic_ns(); now < repeat_at && !answered && !stopping(); now = monotonic_ns()) {
      if (waker_.wait(fd, POLLIN, static_cast<int>((repeat_at - now) / kMillisecondNs) + 1) == 0) continue;
      std::byte buffer[kMaxDatagramBytes + 1];
      const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
      if (got < 0 && errno == ECONNREFUSED) return Greeting::nobody;
      Header header;
      if (got < 0 || !read_header({buffer, static_cast<size_t>(got)}, header) || header.session != nonce)
        continue;
      if (header.type == Type::refuse || header.version != kTransportVersion) return Greeting::refused;
      const auto number = read_number({buffer + kHeaderBytes, static_cast<size_t>(got) - kHeaderBytes});
      if (!number) continue;
      if (header.type == Type::accept && cookie != 0) {
        session = *number;
        return Greeting::accepted;
      }
      if (header.type == Type::cookie && cookie == 0) {
        cookie = *number;
        wait_ns = kFirstBackoffNs;
        answered = true;
      }
    }
  }
  return Greeting::silent;
}

void UdpPublisher::serve(int fd, uint64_t session) {
  // However this ends, nobody may use the descriptor after it.
  struct Leave {
    UdpPublisher& self;
    ~Leave() {
      const std::lock_guard lock(self.mutex_);
      self.fd_ = -1;
      self.session_.reset();
      self.described_ = false;
    }
  } leave{*this};
  int64_t now = monotonic_ns();
  int64_t next_ping = now + kKeepaliveNs;
  {
    const std::lock_guard lock(mutex_);
    session_.emplace(session, now);
    fd_ = fd;
    lost_ = false;
    queue_description();
    if (described_)
      counters_.poses_dropped.add(poses_.send_kept(fd, *session_));  // a stream without a description
  }
  bool lost = false;
  while (!lost && !stopping()) {
    check_described(fd);
    emit_due(fd, now);
    if (now >= next_ping) {
      const std::lock_guard lock(mutex_);
      session_->emit_bare(Type::ping,
                          [fd](auto datagram) { ::send(fd, datagram.data(), datagram.size(), 0); });
      next_ping = now + kKeepaliveNs;
    }
    bool waiting;
    {
      const std::lock_guard lock(mutex_);
      waiting = !session_->sender().idle();
      lost = lost_ || now - session_->heard_at_ns() > kLostAfterNs;
    }
    if (!lost && waker_.wait(fd, POLLIN, waiting ? kTickMs : 200) != 0) receive(fd, lost);
    now = monotonic_ns();
  }
  if (!lost) {  // leaving in order: what still waits goes out once, then the farewell
    emit_due(fd, now);
    const std::lock_guard lock(mutex_);
    session_->emit_bare(Type::bye, [fd](auto datagram) { ::send(fd, datagram.data(), datagram.size(), 0); });
  }
}

void UdpPublisher::check_described(int fd) {
  const std::lock_guard lock(mutex_);
  if (described_ || session_->sender().last_acknowledged() < description_number_) return;
  described_ = true;
  counters_.poses_dropped.add(poses_.send_kept(fd, *session_));
}

void UdpPublisher::emit_due(int fd, int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  session_->emit_due(now_ns, [&](std::span<const std::byte> datagram) {
    // A datagram that does not go out now is repeated like a lost one.
    if (::send(fd, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0)
      counters_.bytes_sent.add(datagram.size());
  });
}

void UdpPublisher::receive(int fd, bool& lost) {
  for (int i = 0; i < 64 && !lost; ++i) {
    std::byte buffer[kMaxDatagramBytes + 1];
    const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
    if (got < 0) {
      lost = errno == ECONNREFUSED;
      return;
    }
    counters_.bytes_received.add(static_cast<uint64_t>(got));
    handle({buffer, static_cast<size_t>(got)}, lost);
  }
}

void UdpPublisher::handle(std::span<const std::byte> datagram, bool& lost) {
  const std::lock_guard lock(mutex_);
  Header header;
  if (!read_header(datagram, header) || header.version != kTransportVersion ||
      header.session != session_->id()) {
    counters_.rejected.add();
    return;
  }
  if (header.type == Type::reset) {
    lost = true;
    return;
  }
  const int64_t now = monotonic_ns();
  if (!session_->heard(header, now)) return;
  if (header.type == Type::bye) {
    lost = true;
    return;
  }
  switch (session_->control(header, datagram.subspan(kHeaderBytes), kMaxControlBytes, now)) {
    case ControlReceiver::Outcome::complete:
      counters_.messages_received.add();
      if (replies_.size() == kMostUnreadReplies) {  // a simulator that never polls must not fill its memory
        replies_.pop_front();
        counters_.rejected.add();
      }
      replies_.push_back(session_->receiver().take());
      break;
    case ControlReceiver::Outcome::corrupt:
      lost = true;
      [[fallthrough]];
    case ControlReceiver::Outcome::ignored:
      counters_.rejected.add();
      break;
    case ControlReceiver::Outcome::kept:
      break;
  }
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri) {
  auto publisher = std::make_unique<UdpPublisher>(uri);
  if (auto started = publisher->start(); !started) return started.error();
  return std::unique_ptr<PublisherLink>(std::move(publisher));
}

}  // namespace fire3dv::transport::udp

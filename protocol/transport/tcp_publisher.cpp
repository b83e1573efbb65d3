#include "protocol/transport/tcp_publisher.h"

#include <netinet/tcp.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <deque>
#include <mutex>
#include <thread>

#include "protocol/transport/address.h"
#include "protocol/transport/clock.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/tcp_frame.h"
#include "protocol/transport/tcp_outbox.h"
#include "protocol/transport/tcp_socket.h"
#include "protocol/transport/waker.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr int64_t kFirstBackoffNs = 10 * kMillisecondNs;
constexpr int64_t kLongestBackoffNs = kSecondNs;
constexpr int64_t kConnectTimeoutNs = 5 * kSecondNs;
constexpr int64_t kPrefaceTimeoutNs = 5 * kSecondNs;
constexpr size_t kMostUnsentControlBytes = 16 << 20;
constexpr size_t kMostUnreadReplies = 1024;

// The simulator's thread sends straight into the socket while that is free; a thread of the link connects,
// finishes what the socket did not take at once, and receives. Nobody holds the lock across anything that
// waits.
class TcpPublisher final : public PublisherLink {
 public:
  explicit TcpPublisher(Uri uri) : uri_(std::move(uri)) {}
  Result<void> start();
  ~TcpPublisher() override;

  size_t max_pose_message_bytes() const override { return kMaxMessageBytes; }
  Result<void> set_description(std::span<const std::byte> message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  bool poll(std::vector<std::byte>& message) override;
  LinkStats stats() const override;

 private:
  // The link's thread.
  void run();
  UniqueFd connect();
  UniqueFd connect_to(const Address& address);
  bool exchange_prefaces(int fd);
  void serve(int fd);
  bool receive(int fd, FrameParser& parser);
  void pause(int64_t ns);
  bool wait_for(int fd, short events, int64_t until_ns);
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }
  void keep_reply(std::vector<std::byte>&& message);
  // A description may be as large as it likes; what piles up behind it may not.
  size_t most_unsent_bytes() const { return kMostUnsentControlBytes + description_.size(); }

  Uri uri_;
  Waker waker_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  LinkCounters counters_;

  mutable std::mutex mutex_;  // guards all that follows
  int fd_ = -1;               // open and greeted; -1 otherwise
  bool broken_ = false;       // the connection is to be given up
  Outbox outbox_;
  wire::Bytes description_;
  std::deque<std::vector<std::byte>> replies_;
};

Result<void> TcpPublisher::start() {
  if (!waker_) return Error{uri_text(uri_) + ": out of file descriptors; close some or raise the limit"};
  thread_ = std::thread([this] { run(); });
  return {};
}

TcpPublisher::~TcpPublisher() {
  stop_.store(true, std::memory_order_relaxed);
  waker_.wake();
  if (thread_.joinable()) thread_.join();
}

// --- the simulator's thread
// ------------------------------------------------------------------------------------------

Result<void> TcpPublisher::set_description(std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes)
    return Error{uri_text(uri_) + ": the description is larger than 256 MiB; describe fewer nodes"};
  const std::lock_guard lock(mutex_);
  description_.assign(message.begin(), message.end());
  if (outbox_.drop_pose()) counters_.poses_dropped.add();  // it belongs to the description before
  if (fd_ < 0) return {};
  // Over the limit the connection starts anew, and with it comes the newest description alone.
  if (!outbox_.control(message, most_unsent_bytes()) || outbox_.flush(fd_) == SendOutcome::broken)
    broken_ = true;
  waker_.wake();
  return {};
}

bool TcpPublisher::publish(const wire::MessagePieces& message, bool) noexcept {
  counters_.messages_sent.add();
  if (message.size() > kMaxMessageBytes) {
    counters_.poses_dropped.add();
    return false;
  }
  try {
    const std::lock_guard lock(mutex_);
    bool overtook = false;
    const SendOutcome outcome = outbox_.pose(fd_, message, overtook);
    if (overtook) counters_.poses_dropped.add();
    if (outcome == SendOutcome::broken) broken_ = true;
    if (outcome != SendOutcome::done && fd_ >= 0) waker_.wake();
    return true;
  } catch (const std::exception&) {  // no memory for the first frame's copy
    counters_.poses_dropped.add();
    return false;
  }
}

void TcpPublisher::send_control(std::span<const std::byte> message) noexcept {
  try {
    const std::lock_guard lock(mutex_);
    if (fd_ < 0) return;
    if (message.size() > kMaxMessageBytes || !outbox_.control(message, most_unsent_bytes())) {
      counters_.rejected.add();
      broken_ = true;  // a control message is not dropped while the rest goes on
    } else if (outbox_.flush(fd_) == SendOutcome::broken) {
      broken_ = true;
    }
    waker_.wake();
  } catch (const std::exception&) {
    counters_.rejected.add();
  }
}

bool TcpPublisher::poll(std::vector<std::byte>& message) {
  const std::lock_guard lock(mutex_);
  if (replies_.empty()) return false;
  message.swap(replies_.front());
  replies_.pop_front();
  return true;
}

LinkStats TcpPublisher::stats() const {
  LinkStats stats = counters_.snapshot();
  const std::lock_guard lock(mutex_);
  stats.bytes_sent = outbox_.bytes_sent();
  stats.peers = fd_ >= 0 ? 1 : 0;
  return stats;
}

// --- the link's thread
// -----------------------------------------------------------------------------------------------

void TcpPublisher::run() {
  int64_t backoff_ns = kFirstBackoffNs;
  while (!stopping()) {
    try {
      const UniqueFd fd = connect();
      if (fd && exchange_prefaces(fd.get())) {
        backoff_ns = kFirstBackoffNs;
        serve(fd.get());
      }
    } catch (const std::exception&) {  // no memory: try again later, like after any other failure
    }
    pause(backoff_ns);
    backoff_ns = std::min(backoff_ns * 2, kLongestBackoffNs);
  }
}

void TcpPublisher::pause(int64_t ns) {
  const int64_t until = monotonic_ns() + ns;
  for (int64_t now = monotonic_ns(); now < until && !stopping(); now = monotonic_ns())
    waker_.wait(-1, 0, static_cast<int>((until - now) / kMillisecondNs) + 1);
}

bool TcpPublisher::wait_for(int fd, short events, int64_t until_ns) {
  while (!stopping()) {
    const int64_t now = monotonic_ns();
    if (now >= until_ns) return false;
    if (waker_.wait(fd, events, static_cast<int>((until_ns - now) / kMillisecondNs) + 1) != 0) return true;
  }
  return false;
}

UniqueFd TcpPublisher::connect() {
  const Lookup lookup(uri_);
  while (!lookup.done() && !stopping()) waker_.wait(-1, 0, 1);
  if (stopping()) return {};
  for (const Address& address : lookup.addresses())
    if (UniqueFd fd = connect_to(address)) return fd;
  return {};
}

UniqueFd TcpPublisher::connect_to(const Address& address) {
  UniqueFd fd(::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return {};
  tune_socket(fd.get());
  if (::connect(fd.get(), address.get(), address.length) != 0) {
    if (errno != EINPROGRESS || !wait_for(fd.get(), POLLOUT, monotonic_ns() + kConnectTimeoutNs)) return {};
    int error = 0;
    socklen_t length = sizeof error;
    if (::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &length) != 0 || error != 0) return {};
  }
  return connected_to_itself(fd.get()) ? UniqueFd() : std::move(fd);
}

bool TcpPublisher::exchange_prefaces(int fd) {
  const PrefaceBytes ours = write_preface({});
  if (::send(fd, ours.data(), ours.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(ours.size())) return false;
  PrefaceBytes theirs{};
  size_t got = 0;
  const int64_t until = monotonic_ns() + kPrefaceTimeoutNs;
  while (got < theirs.size()) {
    if (!wait_for(fd, POLLIN, until)) return false;
    const ssize_t received = ::recv(fd, theirs.data() + got, theirs.size() - got, 0);
    if (received < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (received <= 0) return false;
    got += static_cast<size_t>(received);
  }
  Preface preface;
  const bool welcome = read_preface(theirs, preface) && preface.version == kTransportVersion &&
                       preface.status == PrefaceStatus::ok;
  if (!welcome) counters_.rejected.add();
  return welcome;
}

void TcpPublisher::serve(int fd) {
  // However this ends, nobody may use the descriptor after it.
  struct Leave {
    TcpPublisher& self;
    ~Leave() {
      const std::lock_guard lock(self.mutex_);
      self.fd_ = -1;
    }
  } leave{*this};
  {
    const std::lock_guard lock(mutex_);
    outbox_.start_connection();
    if (!description_.empty()) outbox_.control(description_, kMaxMessageBytes);
    broken_ = false;
    fd_ = fd;  // from here on the simulator's thread may send
  }
  FrameParser parser;
  bool alive = true;
  while (alive && !stopping()) {
    short events = POLLIN;
    {
      const std::lock_guard lock(mutex_);
      if (outbox_.waits_to_send() && outbox_.flush(fd) == SendOutcome::broken) broken_ = true;
      if (broken_) break;
      if (outbox_.waits_to_send()) events |= POLLOUT;
    }
    if ((waker_.wait(fd, events, 1000) & (POLLIN | POLLERR | POLLHUP)) != 0) alive = receive(fd, parser);
  }
  {
    const std::lock_guard lock(mutex_);
    if (alive && !broken_) outbox_.flush(fd);  // a last goodbye, as far as it goes without waiting
  }
}

bool TcpPublisher::receive(int fd, FrameParser& parser) {
  std::byte buffer[16384];
  const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  counters_.bytes_received.add(static_cast<uint64_t>(got));
  const auto fault = parser.feed({buffer, static_cast<size_t>(got)}, [this](FrameKind kind, auto&& message) {
    if (kind == FrameKind::control)
      keep_reply(std::move(message));
    else
      counters_.rejected.add();
  });
  if (fault == FrameParser::Fault::none) return true;
  counters_.rejected.add();
  return false;
}

void TcpPublisher::keep_reply(std::vector<std::byte>&& message) {
  counters_.messages_received.add();
  const std::lock_guard lock(mutex_);
  if (replies_.size() == kMostUnreadReplies) {  // a simulator that never polls must not fill its memory
    replies_.pop_front();
    counters_.rejected.add();
  }
  replies_.push_back(std::move(message));
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri) {
  auto publisher = std::make_unique<TcpPublisher>(uri);
  if (auto started = publisher->start(); !started) return started.error();
  return std::unique_ptr<PublisherLink>(std::move(publisher));
}

}  // namespace fire3dv::transport::tcp

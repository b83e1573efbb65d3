#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "base/clock.h"
#include "base/files.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/tcp/tcp_connection.h"
#include "protocol/transport/tcp/tcp_frame.h"
#include "protocol/transport/tcp/tcp_outbox.h"
#include "protocol/transport/tcp/tcp_send_queue.h"
#include "protocol/wire/image.h"

namespace fire3dv::transport::tcp {
namespace {

constexpr int64_t kConnectTimeoutNs = 5 * kSecondNs;
constexpr int64_t kGreetingTimeoutNs = 5 * kSecondNs;
constexpr size_t kMaxUnsentControlBytes = 16 << 20;
// Replies have kilobytes; an invalid one must not exhaust a simulator's memory.
constexpr size_t kMaxReplyBytes = 64 << 20;
constexpr size_t kMaxUnreadImageBytes = size_t{256} << 20;
constexpr size_t kMaxImageBytes = size_t{1} << 30;  // limit if images of this size were requested

// One connection, from its first byte.
struct Connection {
  UnforkableFd fd;                  // a child's end of it would delay the renderer's notice of our end
  std::unique_ptr<TlsSession> tls;  // null: tcp://
  std::vector<std::byte> plain;     // received, not parsed yet
};

// TCP publisher. The simulator's thread sends directly while the socket has space. The link's thread
// connects, sends the remainder, and receives. The lock is never held across a blocking call.
class TcpPublisher final : public NetworkPublisher {
 public:
  TcpPublisher(Uri uri, TlsContext context)
      : NetworkPublisher(std::move(uri)), context_(std::move(context)) {}
  ~TcpPublisher() override { thread_.stop(); }

  size_t max_pose_message_bytes() const override { return kMaxMessageBytes; }
  Result<void> set_description(std::span<const std::byte> message) override;
  Result<void> put_state(uint64_t key, SharedBytes message) override;
  bool publish(const wire::MessagePieces& message, bool last_part) noexcept override;
  bool takes_partial_frames() const override { return true; }
  bool publish_partial(const wire::MessagePieces& partial,
                       std::span<const wire::MessagePieces> whole) noexcept override;
  void send_control(std::span<const std::byte> message) noexcept override;
  Result<void> make_room_for_images(size_t block_bytes, size_t requests) override;
  std::optional<Image> poll_image() override;
  LinkStats stats() const override;

 private:
  // Used on the link's thread.
  bool visit(const Address& address) override;
  UnforkableFd connect_to(const Address& address);
  bool greet(Connection& connection);
  bool receive_some(Connection& connection, int64_t until_ns);
  void serve(Connection& connection);
  bool receive(Connection& connection, FrameParser& parser);
  bool take(std::span<const std::byte> plain, FrameParser& parser);
  void queue_image(std::vector<std::byte>&& message);

  // Requires mutex_. The limit excludes the description, which may have any size.
  size_t max_unsent_bytes() const {
    return kMaxUnsentControlBytes + (description_ ? description_->size() : 0);
  }
  template <typename Send>
  bool publish_by(size_t bytes, Send send) noexcept;
  void dropped() {
    counters_.poses_dropped.add();
    counters_.frames_dropped.add();
  }

  const TlsContext context_;

  // Guarded by mutex_.
  int fd_ = -1;          // open and greeted; -1 otherwise
  bool broken_ = false;  // the connection must be closed
  Outbox outbox_;
  SharedBytes description_;  // null: none yet
  bool wants_images_ = false;
  std::atomic<size_t> max_received_bytes_{kMaxReplyBytes};  // limit of an incomplete message
  ImageQueue<std::vector<std::byte>> images_{kMaxUnreadImageBytes, wire::kMaxImageRequests};
};

// --- the simulator's thread

Result<void> TcpPublisher::set_description(std::span<const std::byte> message) {
  if (is_inherited()) return inherited_error();
  if (message.size() > kMaxMessageBytes)
    return Error{uri_text(uri_) + ": the description is larger than 256 MiB; describe fewer nodes"};
  SharedBytes earlier = share(message);
  const std::lock_guard lock(mutex_);
  description_.swap(earlier);          // frees the old one after the lock
  if (outbox_.drop_pose()) dropped();  // it belongs to the old description
  outbox_.start_description();
  if (fd_ < 0) return {};
  // Over the limit: reconnecting sends the newest description only.
  if (!outbox_.control(description_, max_unsent_bytes()) || outbox_.flush(fd_) == SendOutcome::broken)
    broken_ = true;
  thread_.wake();
  return {};
}

Result<void> TcpPublisher::put_state(uint64_t key, SharedBytes message) {
  if (is_inherited()) return inherited_error();
  if (message->size() > kMaxMessageBytes)
    return Error{uri_text(uri_) + ": a scene edit is larger than 256 MiB; split it or name a file"};
  const std::lock_guard lock(mutex_);
  outbox_.state(key, std::move(message));
  if (fd_ < 0) return {};
  if (outbox_.flush(fd_) == SendOutcome::broken) broken_ = true;
  thread_.wake();
  return {};
}

bool TcpPublisher::publish(const wire::MessagePieces& message, bool) noexcept {
  return publish_by(message.size(), [&](bool& overtook) { return outbox_.pose(fd_, message, overtook); });
}

bool TcpPublisher::publish_partial(const wire::MessagePieces& partial,
                                   std::span<const wire::MessagePieces> whole) noexcept {
  return publish_by(whole[0].size(),
                    [&](bool& overtook) { return outbox_.partial_pose(fd_, partial, whole[0], overtook); });
}

template <typename Send>
bool TcpPublisher::publish_by(size_t bytes, Send send) noexcept {
  counters_.messages_sent.add();
  if (is_inherited() || bytes > kMaxMessageBytes) {
    dropped();
    return false;
  }
  try {
    const std::lock_guard lock(mutex_);
    bool overtook = false;
    const SendOutcome outcome = send(overtook);
    if (overtook) dropped();
    if (outcome == SendOutcome::broken) broken_ = true;
    if (outcome != SendOutcome::done && fd_ >= 0) thread_.wake();
    return true;
  } catch (const std::exception&) {  // out of memory for the first frame's copy
    dropped();
    return false;
  }
}

void TcpPublisher::send_control(std::span<const std::byte> message) noexcept {
  if (is_inherited()) return;
  try {
    SharedBytes shared = share(message);
    const std::lock_guard lock(mutex_);
    if (fd_ < 0) return;
    if (message.size() > kMaxMessageBytes || !outbox_.control(std::move(shared), max_unsent_bytes())) {
      counters_.reject(Cause::unread);
      broken_ = true;  // a control message must not be dropped on a live connection
    } else if (outbox_.flush(fd_) == SendOutcome::broken) {
      broken_ = true;
    }
    thread_.wake();
  } catch (const std::exception&) {
    counters_.reject(Cause::no_memory);
  }
}

LinkStats TcpPublisher::stats() const {
  LinkStats stats = counters_.snapshot();
  if (is_inherited()) return stats;
  const std::lock_guard lock(mutex_);
  stats.bytes_sent = outbox_.bytes_sent();
  stats.peers = fd_ >= 0 ? 1 : 0;
  return stats;
}

// --- the link's thread

bool TcpPublisher::visit(const Address& address) {
  Connection connection;
  connection.fd = connect_to(address);
  if (!connection.fd) return false;
  set_absence({});
  if (!greet(connection)) return false;
  set_problem({});
  serve(connection);
  return true;
}

UnforkableFd TcpPublisher::connect_to(const Address& address) {
  UnforkableFd fd = UnforkableFd::open(
      [&] { return ::socket(address.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); });
  if (!fd) return {};
  tune_socket(fd.get());
  if (::connect(fd.get(), address.get(), address.length) != 0) {
    int error = errno;
    if (error == EINPROGRESS) {
      socklen_t length = sizeof error;
      error = ETIMEDOUT;
      if (thread_.wait_for(fd.get(), POLLOUT, monotonic_ns() + kConnectTimeoutNs) &&
          ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &length) != 0)
        error = errno;
    }
    if (error != 0) {
      set_absence(system_reason(error));
      return {};
    }
  }
  return connected_to_itself(fd.get()) ? UnforkableFd() : std::move(fd);
}

// Sends data that must fit an empty socket buffer.
bool send_whole(int fd, std::span<const std::byte> bytes) {
  return bytes.empty() ||
         ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

bool TcpPublisher::receive_some(Connection& connection, int64_t until_ns) {
  const int fd = connection.fd.get();
  if (!thread_.wait_for(fd, POLLIN, until_ns)) return false;
  std::byte buffer[16384];
  const ssize_t got = ::recv(fd, buffer, sizeof buffer, 0);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  const std::span<const std::byte> came(buffer, static_cast<size_t>(got));
  if (!connection.tls) {
    connection.plain.insert(connection.plain.end(), came.begin(), came.end());
    return true;
  }
  std::vector<std::byte> to_send;
  const bool sound = connection.tls->receive(came, connection.plain, to_send);
  const bool sent = send_whole(fd, to_send);
  if (!sound && !connection.tls->problem().empty()) {
    counters_.reject(Cause::bad_key);
    set_problem(uri_text(uri_) + ": " + connection.tls->problem());
  }
  return sound && sent;
}

bool TcpPublisher::greet(Connection& connection) {
  const int64_t until = monotonic_ns() + kGreetingTimeoutNs;
  const int fd = connection.fd.get();
  std::vector<std::byte> to_send;
  if (context_) {
    connection.tls = TlsSession::client(context_, uri_.host);
    if (!connection.tls || !connection.tls->handshake(to_send) || !send_whole(fd, to_send)) return false;
    while (!connection.tls->established())
      if (!receive_some(connection, until)) return false;
    to_send.clear();
  }
  const PrefaceBytes ours = write_preface({});
  if (!connection.tls)
    to_send.assign(ours.begin(), ours.end());
  else if (!connection.tls->seal(ours, to_send))
    return false;
  if (!send_whole(fd, to_send)) return false;
  while (connection.plain.size() < kPrefaceBytes)
    if (!receive_some(connection, until)) return false;
  Preface preface;
  const bool ours_too = read_preface(std::span(connection.plain).first<kPrefaceBytes>(), preface);
  connection.plain.erase(connection.plain.begin(), connection.plain.begin() + kPrefaceBytes);
  if (ours_too && preface.version == kTransportVersion && preface.status == PrefaceStatus::ok) return true;
  if (!ours_too) {
    counters_.reject(Cause::malformed);
    set_problem(uri_text(uri_) + ": what listens there is not a FIRE-3DV renderer");
  } else if (preface.version != kTransportVersion) {
    counters_.reject(Cause::version);
    set_problem(uri_text(uri_) + ": the renderer speaks transport version " +
                std::to_string(preface.version) + ", this program " + std::to_string(kTransportVersion) +
                "; use the same version on both sides");
  } else {
    counters_.reject(Cause::full);
    set_problem(uri_text(uri_) + ": the renderer has as many publishers as it allows");
  }
  return false;
}

void TcpPublisher::serve(Connection& connection) {
  const int fd = connection.fd.get();
  // Resets fd_ on every exit path, before the descriptor is closed.
  struct Leave {
    TcpPublisher& self;
    ~Leave() {
      const std::lock_guard lock(self.mutex_);
      self.fd_ = -1;
      self.outbox_.start_connection(nullptr);
    }
  } leave{*this};
  {
    const std::lock_guard lock(mutex_);
    outbox_.start_connection(connection.tls.get());
    if (description_) outbox_.control(description_, kMaxMessageBytes);
    broken_ = false;
    fd_ = fd;  // the simulator's thread may send from here on
  }
  FrameParser parser(
      [this](size_t bytes) { return bytes <= max_received_bytes_.load(std::memory_order_relaxed); });
  bool alive = take(connection.plain, parser);  // received together with the greeting
  while (alive && !thread_.stopping()) {
    short events = POLLIN;
    {
      const std::lock_guard lock(mutex_);
      if (outbox_.waits_to_send() && outbox_.flush(fd) == SendOutcome::broken) broken_ = true;
      if (broken_) break;
      if (outbox_.waits_to_send()) events |= POLLOUT;
    }
    if ((thread_.wait(fd, events, kSecondNs) & (POLLIN | POLLERR | POLLHUP)) != 0)
      alive = receive(connection, parser);
  }
  {
    const std::lock_guard lock(mutex_);
    if (alive && !broken_) outbox_.flush(fd);  // a last goodbye, as far as possible without blocking
  }
}

bool TcpPublisher::receive(Connection& connection, FrameParser& parser) {
  std::byte buffer[65536];
  const ssize_t got = ::recv(connection.fd.get(), buffer, sizeof buffer, 0);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  counters_.bytes_received.add(static_cast<uint64_t>(got));
  const std::span<const std::byte> came(buffer, static_cast<size_t>(got));
  std::span<const std::byte> plain = came;
  if (connection.tls) {  // one session encrypts and decrypts: both under the lock
    const std::lock_guard lock(mutex_);
    connection.plain.clear();
    std::vector<std::byte> to_send;
    const bool sound = connection.tls->receive(came, connection.plain, to_send);
    outbox_.sealed(to_send);
    if (!sound && !connection.tls->problem().empty()) {
      // The listener verifies our certificate after our side of the handshake is done.
      counters_.reject(Cause::bad_key);
      set_problem_locked(uri_text(uri_) + ": " + connection.tls->problem());
    }
    if (!sound) return false;
    plain = connection.plain;
  }
  return take(plain, parser);
}

// Parses without the lock: a growing large reply is copied several times, and the simulator must not wait for
// that.
bool TcpPublisher::take(std::span<const std::byte> plain, FrameParser& parser) {
  const auto fault = parser.feed(plain, [this](FrameKind kind, auto&& message) {
    if (kind == FrameKind::image) return queue_image(std::move(message));
    if (kind != FrameKind::control) return counters_.reject(Cause::version);
    if (message.size() > kMaxReplyBytes) return counters_.reject(Cause::oversize);
    const std::lock_guard lock(mutex_);
    queue_reply(std::move(message));
  });
  switch (fault) {
    case FrameParser::Fault::none:
      return true;
    case FrameParser::Fault::bad_header:
      counters_.reject(Cause::malformed);
      return false;
    case FrameParser::Fault::too_long:
      counters_.reject(Cause::oversize);
      return false;
    case FrameParser::Fault::no_memory:
      counters_.reject(Cause::no_memory);
      return false;
  }
  return false;
}

void TcpPublisher::queue_image(std::vector<std::byte>&& message) {
  const auto block = wire::read_image_block(message);
  if (!block) return counters_.reject(Cause::malformed);
  const uint64_t request = block->request;
  // Freed without the lock, which the simulator's publish takes.
  std::vector<std::vector<std::byte>> given_up;
  const std::lock_guard lock(mutex_);
  if (!wants_images_) return counters_.reject(Cause::unread);
  given_up = images_.push(request, std::move(message));
  if (!given_up.empty()) counters_.images_dropped.add(given_up.size());
}

Result<void> TcpPublisher::make_room_for_images(size_t block_bytes, size_t requests) {
  if (is_inherited()) return inherited_error();
  if (block_bytes > kMaxMessageBytes)
    return Error{uri_text(uri_) + ": an image of more than 256 MiB; request a smaller one, or fewer outputs"};
  const std::lock_guard lock(mutex_);
  wants_images_ = true;
  images_.raise_limit(std::min(block_bytes * requests, kMaxImageBytes));
  max_received_bytes_.store(kMaxMessageBytes, std::memory_order_relaxed);
  return {};
}

std::optional<PublisherLink::Image> TcpPublisher::poll_image() {
  if (is_inherited()) return {};
  auto block = std::make_shared<std::vector<std::byte>>();
  {
    const std::lock_guard lock(mutex_);
    if (images_.empty()) return {};
    *block = images_.pop();
  }
  counters_.images_received.add();
  const std::span<const std::byte> bytes(*block);
  return Image{std::move(block), bytes};
}

}  // namespace

Result<std::unique_ptr<PublisherLink>> make_publisher(const Uri& uri, const PublisherOptions& options) {
  TlsContext context;
  if (uri.scheme == Uri::Scheme::tls) {
    auto made = make_client_context(uri_text(uri), options.tls);
    if (!made) return made.error();
    context = *made;
  }
  auto publisher = std::make_unique<TcpPublisher>(uri, std::move(context));
  if (auto started = publisher->start(); !started) return started.error();
  return std::unique_ptr<PublisherLink>(std::move(publisher));
}

}  // namespace fire3dv::transport::tcp

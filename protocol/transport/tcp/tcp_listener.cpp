#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <unordered_map>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/tcp/tcp_peer.h"  // defines the Asio configuration
#include "protocol/wire/image.h"

#include <asio/executor_work_guard.hpp>
#include <asio/post.hpp>

namespace fire3dv::transport::tcp {
namespace {

using asio::ip::tcp;

constexpr size_t kMaxWaitingMessages = 1024;
constexpr size_t kMaxWaitingBytes = 64 << 20;
constexpr size_t kLeastHalfOpen = 16;

class TcpListener final : public NetworkListener, public PeerHost {
 public:
  TcpListener(std::string uri, const ListenerOptions& options, TlsContext context, ListenerHooks hooks)
      : NetworkListener(std::move(uri), options),
        context_(std::move(context)),
        hooks_(std::move(hooks)),
        half_open_budget_(pool_->add_peer(uri_ + ", connections without a greeting")) {}
  Result<void> start(BoundSocket bound);
  ~TcpListener() override;

  void poll(const std::function<void(const LinkEvent&)>& on_event) override;
  void send(PeerId peer, std::span<const std::byte> message) override;
  bool carries_images() const override { return true; }
  bool carries_input() const override { return true; }
  bool send_image(PeerId peer, uint64_t request, std::span<const std::byte> head, size_t pixel_bytes,
                  const FillPixels& fill) override;

 private:
  void run(asio::io_context& io);
  void accept_next();
  void accepted(tcp::socket socket);
  void end_half_open();
  bool make_room();
  std::shared_ptr<SendQueue> queue_of(PeerId peer) const;
  void send_on(PeerId peer, SendQueue& queue);

  PrefaceStatus greet(Peer& peer) override;
  void received_bytes(size_t bytes) override { counters_.bytes_received.add(bytes); }
  void run_handshake(std::function<void()> step, std::function<void()> done) override;
  void skipped_poses(size_t count) override {
    counters_.poses_dropped.add(count);
    counters_.reject(Cause::no_memory, count);
  }
  std::string refusal_text(const Peer& peer, Cause cause) const override {
    return NetworkListener::refusal_text(peer.id, cause);
  }
  std::optional<Cause> received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) override;
  bool should_pause(const Peer& peer) override;
  void ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) override;

  const TlsContext context_;  // null: tcp://
  const ListenerHooks hooks_;
  const std::shared_ptr<PeerBudget> half_open_budget_;
  mutable std::mutex queues_mutex_;
  std::unordered_map<PeerId, std::shared_ptr<SendQueue>> queues_;  // of greeted peers
  asio::io_context io_{1};
  // Declared after io_: its handlers hold peers, whose sockets belong to io_.
  asio::io_context handshake_io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer accept_again_{io_};
  std::atomic<bool> held_back_{false};  // a peer waits for the next poll

  // Used on the listener's thread only.
  std::deque<std::shared_ptr<Peer>> half_open_;  // oldest first
  std::unordered_map<PeerId, std::shared_ptr<Peer>> peers_;

  LinkThread handshake_thread_;  // TLS only
};

Result<void> TcpListener::start(BoundSocket bound) {
  asio::error_code error;
  const auto protocol = bound.address.family() == AF_INET6 ? tcp::v6() : tcp::v4();
  const int fd = ::dup(bound.fd.get());  // Asio owns its own descriptor
  if (fd < 0) return Error{uri_ + ": out of file descriptors; close some or raise the limit"};
  acceptor_.assign(protocol, fd, error);
  if (error) {
    ::close(fd);
    return Error{uri_ + ": cannot listen: " + error.message()};
  }
  accept_next();
  if (context_) {
    auto started = handshake_thread_.start(uri_, [this] { run(handshake_io_); });
    if (!started) return started;
  }
  return thread_.start(uri_, [this] { run(io_); });
}

TcpListener::~TcpListener() {
  io_.stop();
  handshake_io_.stop();
  handshake_thread_.stop();
  thread_.stop();
}

// Only std::bad_alloc arrives here: the affected message is dropped and the others continue.
void TcpListener::run(asio::io_context& io) {
  const auto work = asio::make_work_guard(io);
  while (!io.stopped()) {
    try {
      io.run();
    } catch (const std::exception&) {
      counters_.reject(Cause::no_memory);
    }
  }
}

// Runs TLS handshakes on their own thread. An RSA-4096 handshake takes milliseconds, unauthenticated peers
// may start one, and established peers must not wait.
void TcpListener::run_handshake(std::function<void()> step, std::function<void()> done) {
  asio::post(handshake_io_, [this, step = std::move(step), done = std::move(done)]() mutable {
    if (hooks_.before_handshake_step) hooks_.before_handshake_step();
    try {
      step();
    } catch (const std::exception&) {  // `done` finds no outcome
    }
    step = nullptr;  // the peer that it holds is destroyed on the listener's thread
    asio::post(io_, std::move(done));
  });
}

void TcpListener::accept_next() {
  acceptor_.async_accept([this](const asio::error_code& error, tcp::socket socket) {
    if (!error) {
      try {
        accepted(std::move(socket));
      } catch (const std::exception&) {  // the next connection may find memory again
        counters_.reject(Cause::no_memory);
      }
      return accept_next();
    }
    // Usually out of descriptors: an immediate retry would only burn CPU time.
    reject(Cause::system, "cannot accept a connection: " + error.message());
    accept_again_.expires_after(std::chrono::milliseconds(100));
    accept_again_.async_wait([this](const asio::error_code& cancelled) {
      if (!cancelled) accept_next();
    });
  });
}

void TcpListener::accepted(tcp::socket socket) {
  if (half_open_.size() >= std::max<size_t>(kLeastHalfOpen, options_.max_peers)) end_half_open();
  Result<BudgetCharge> charge =
      BudgetCharge::take(half_open_budget_, Resource::received_bytes, Peer::kHalfOpenBytes);
  if (!charge) return reject(Cause::no_memory, "a connection was refused: " + charge.error().message);
  std::unique_ptr<TlsSession> tls;
  if (context_) {
    tls = TlsSession::server(context_);
    if (!tls) return counters_.reject(Cause::no_memory);
  }
  half_open_.push_back(std::make_shared<Peer>(std::move(socket), *this, std::move(*charge), std::move(tls)));
  half_open_.back()->start();
}

// Ends the oldest ungreeted connection of the address with the most of them, so that one silent host cannot
// lock out the others.
void TcpListener::end_half_open() {
  std::map<std::string, size_t> count_of_address;
  size_t most = 0;
  for (const auto& peer : half_open_) most = std::max(most, ++count_of_address[peer->remote()]);
  const auto oldest = std::find_if(half_open_.begin(), half_open_.end(), [&](const auto& peer) {
    return count_of_address[peer->remote()] == most;
  });
  const std::shared_ptr<Peer> peer = *oldest;
  peer->end("too many connections without a greeting", Cause::silent);
}

PrefaceStatus TcpListener::greet(Peer& peer) {
  if (is_full(peers_.size()) && !make_room()) return PrefaceStatus::full;
  peer.id = ++last_id_;
  peer.greeted_at_ns = monotonic_ns();
  peer.budget = connected(peer.id, peer.remote());
  peer.queue = std::make_shared<SendQueue>(peer.budget);
  {
    const std::lock_guard lock(queues_mutex_);
    queues_.emplace(peer.id, peer.queue);
  }
  peers_.emplace(peer.id, peer.shared_from_this());
  std::erase_if(half_open_, [&](const auto& other) { return other.get() == &peer; });
  counters_.peers.set(peers_.size());
  return PrefaceStatus::ok;
}

// Ends the unaccepted peer with the longest silence.
bool TcpListener::make_room() {
  const int64_t now_ns = monotonic_ns();
  std::shared_ptr<Peer> guest;
  for (const auto& [id, peer] : peers_) {
    if (guest && guest->heard_at_ns() <= peer->heard_at_ns()) continue;
    if (may_evict(id, peer->greeted_at_ns, peer->heard_at_ns(), now_ns)) guest = peer;
  }
  if (!guest) return false;
  guest->end(kEvictionReason, Cause::silent);
  return !is_full(peers_.size());
}

std::optional<Cause> TcpListener::received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) {
  switch (kind) {
    case FrameKind::pose:
      inbox_.pose(peer.id, std::move(message), options_.delivery == Delivery::newest);
      return {};
    case FrameKind::control:
      return inbox_.control(peer.id, std::move(message));
    case FrameKind::state:
      return inbox_.state(peer.id, std::move(message));
    case FrameKind::partial_pose:
      inbox_.partial_pose(peer.id, std::move(message), 0);
      return {};
    case FrameKind::image:
      break;  // sent by listeners only
  }
  counters_.reject(Cause::version);  // kind of a later version: skipped, since its length is known
  return {};
}

bool TcpListener::should_pause(const Peer& peer) {
  bool full = inbox_.is_full_of_states(peer.id);
  if (options_.delivery == Delivery::all) {
    const Inbox::Waiting waiting = inbox_.waiting(peer.id);
    full = full || waiting.messages >= kMaxWaitingMessages || waiting.bytes >= kMaxWaitingBytes;
  }
  if (!full) return false;
  held_back_.store(true, std::memory_order_relaxed);
  return true;
}

void TcpListener::ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) {
  if (cause) counters_.reject(*cause);
  if (peer.id != 0) {
    inbox_.disconnected(peer.id, reason);
    peers_.erase(peer.id);
    const std::lock_guard lock(queues_mutex_);
    queues_.erase(peer.id);
    counters_.peers.set(peers_.size());
    return;
  }
  inbox_.note(cause, reason, "a connection from " + peer.remote() + " was closed: " + reason);
  std::erase_if(half_open_, [&](const auto& other) { return other.get() == &peer; });
}

void TcpListener::poll(const std::function<void(const LinkEvent&)>& on_event) {
  inbox_.poll(on_event);
  if (!held_back_.exchange(false, std::memory_order_relaxed)) return;
  asio::post(io_, [this] {
    for (const auto& [id, peer] : peers_) peer->resume();
  });
}

std::shared_ptr<SendQueue> TcpListener::queue_of(PeerId peer) const {
  const std::lock_guard lock(queues_mutex_);
  const auto found = queues_.find(peer);
  return found != queues_.end() ? found->second : nullptr;
}

void TcpListener::send_on(PeerId peer, SendQueue& queue) {
  if (const size_t dropped = queue.take_dropped_images(); dropped != 0) counters_.images_dropped.add(dropped);
  if (!queue.take_wake()) return;
  asio::post(io_, [this, peer] {
    const auto found = peers_.find(peer);
    if (found == peers_.end()) return;
    const std::shared_ptr<Peer> peer_ref = found->second;  // keeps the peer alive: sending may end it
    peer_ref->write();
  });
}

void TcpListener::send(PeerId peer, std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes) return counters_.reject(Cause::oversize);
  counters_.messages_sent.add();
  counters_.bytes_sent.add(kFrameHeaderBytes + message.size());
  const std::shared_ptr<SendQueue> queue = queue_of(peer);
  if (!queue) return;
  const auto header = write_frame_header(FrameKind::control, static_cast<uint32_t>(message.size()));
  std::vector<std::byte> framed(header.size() + message.size());
  std::copy(message.begin(), message.end(), std::copy(header.begin(), header.end(), framed.begin()));
  if (queue->add_reply(std::move(framed))) return send_on(peer, *queue);
  queue->close();
  asio::post(io_, [this, peer] {
    const auto found = peers_.find(peer);
    if (found == peers_.end()) return;
    const std::shared_ptr<Peer> peer_ref = found->second;
    peer_ref->end("it does not read its replies", Cause::unread);
  });
}

bool TcpListener::send_image(PeerId peer, uint64_t request, std::span<const std::byte> head,
                             size_t pixel_bytes, const FillPixels& fill) {
  const size_t pixels = wire::pixels_at(head.size());
  const size_t bytes = pixels + pixel_bytes;
  const std::shared_ptr<SendQueue> queue = queue_of(peer);
  std::optional<BudgetCharge> charge;
  if (queue && bytes <= kMaxMessageBytes) charge = queue->charge_image(request, bytes);
  if (!charge) {
    counters_.images_dropped.add(1 + (queue ? queue->take_dropped_images() : 0));
    return false;
  }
  SendQueue::Bytes block;
  block.charge = std::move(*charge);
  block.bytes.resize(bytes);
  wire::write_image_block_head(block.bytes, request, head);
  fill(std::span(block.bytes).subspan(pixels));
  counters_.images_sent.add();
  counters_.bytes_sent.add(kFrameHeaderBytes + bytes);
  queue->add_image(request, std::move(block));
  send_on(peer, *queue);
  return true;
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options,
                                                    ListenerHooks hooks) {
  TlsContext context;
  if (uri.scheme == Uri::Scheme::tls) {
    auto made = make_server_context(uri_text(uri), options.tls);
    if (!made) return made.error();
    context = *made;
  }
  auto bound = bind_listener(uri, SOCK_STREAM, options.insecure || context != nullptr);
  if (!bound) return bound.error();
  Uri chosen = uri;
  chosen.port = bound->address.port();
  auto listener =
      std::make_unique<TcpListener>(uri_text(chosen), options, std::move(context), std::move(hooks));
  if (auto started = listener->start(std::move(*bound)); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::tcp

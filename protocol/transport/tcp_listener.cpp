#include "protocol/transport/tcp_listener.h"

#include <algorithm>
#include <atomic>
#include <unordered_map>

#include "protocol/transport/address.h"
#include "protocol/transport/network_listener.h"
#include "protocol/transport/tcp_peer.h"  // says how Asio is used
#include "protocol/wire/image_block.h"

#include <asio/executor_work_guard.hpp>
#include <asio/post.hpp>

namespace fire3dv::transport::tcp {
namespace {

using asio::ip::tcp;

constexpr size_t kMostWaitingMessages = 1024;
constexpr size_t kMostWaitingBytes = 64 << 20;
constexpr size_t kLeastHalfOpen = 16;

class TcpListener final : public NetworkListener, public PeerHost {
 public:
  TcpListener(std::string uri, const ListenerOptions& options, TlsContext context)
      : NetworkListener(std::move(uri), options),
        context_(std::move(context)),
        budget_(options.max_memory_bytes) {}
  Result<void> start(BoundSocket bound);
  ~TcpListener() override;

  void poll(const std::function<void(const LinkEvent&)>& on_event) override;
  void send(PeerId peer, std::span<const std::byte> message) override;
  bool carries_images() const override { return true; }
  bool send_image(PeerId peer, uint64_t request, std::span<const std::byte> head, size_t pixel_bytes,
                  const FillPixels& fill) override;

 private:
  void run();
  void accept();
  void accepted(tcp::socket socket);
  bool make_room();

  PrefaceStatus greet(Peer& peer) override;
  void received_bytes(size_t bytes) override { counters_.bytes_received.add(bytes); }
  void dropped_images(size_t count) override { counters_.images_dropped.add(count); }
  std::optional<Cause> received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) override;
  bool hold_back(const Peer& peer) override;
  void ended(Peer& peer, const std::string& reason, std::optional<Cause> cause) override;

  const TlsContext context_;  // null: tcp://
  MemoryBudget budget_;
  MemoryBudget image_budget_{size_t{1} << 30};
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer accept_again_{io_};
  std::atomic<bool> held_back_{false};  // some peer waits for the next poll

  // On the listener's thread alone.
  std::deque<std::shared_ptr<Peer>> half_open_;  // oldest first
  std::unordered_map<PeerId, std::shared_ptr<Peer>> peers_;
};

Result<void> TcpListener::start(BoundSocket bound) {
  asio::error_code error;
  const auto protocol = bound.address.family() == AF_INET6 ? tcp::v6() : tcp::v4();
  const int fd = ::dup(bound.fd.get());  // Asio owns one of its own
  if (fd < 0) return Error{uri_ + ": out of file descriptors; close some or raise the limit"};
  acceptor_.assign(protocol, fd, error);
  if (error) {
    ::close(fd);
    return Error{uri_ + ": cannot listen: " + error.message()};
  }
  accept();
  return thread_.start(uri_, [this] { run(); });
}

TcpListener::~TcpListener() {
  io_.stop();
  thread_.stop();
}

// Only lack of memory throws here; whoever's message it was is dropped with it and the others go on.
void TcpListener::run() {
  const auto work = asio::make_work_guard(io_);
  while (!io_.stopped()) {
    try {
      io_.run();
    } catch (const std::exception&) {
      counters_.reject(Cause::no_memory);
    }
  }
}

void TcpListener::accept() {
  acceptor_.async_accept([this](const asio::error_code& error, tcp::socket socket) {
    if (!error) {
      try {
        accepted(std::move(socket));
      } catch (const std::exception&) {  // the next one may find memory again
        counters_.reject(Cause::no_memory);
      }
      return accept();
    }
    // Out of descriptors, most often: asking again at once would only burn time.
    reject(Cause::system, "cannot accept a connection: " + error.message());
    accept_again_.expires_after(std::chrono::milliseconds(100));
    accept_again_.async_wait([this](const asio::error_code& cancelled) {
      if (!cancelled) accept();
    });
  });
}

void TcpListener::accepted(tcp::socket socket) {
  // Who connects and says nothing must not keep others out: the oldest of them makes room.
  if (half_open_.size() >= std::max<size_t>(kLeastHalfOpen, options_.max_peers))
    half_open_.front()->end("too many connections without a greeting", Cause::silent);
  std::unique_ptr<TlsSession> tls;
  if (context_) {
    tls = TlsSession::server(context_);
    if (!tls) return counters_.reject(Cause::no_memory);
  }
  half_open_.push_back(std::make_shared<Peer>(std::move(socket), *this, budget_, std::move(tls)));
  half_open_.back()->start();
}

PrefaceStatus TcpListener::greet(Peer& peer) {
  if (is_full(peers_.size()) && !make_room()) return PrefaceStatus::full;
  peer.id = ++last_id_;
  peer.greeted_at_ns = monotonic_ns();
  peers_.emplace(peer.id, peer.shared_from_this());
  std::erase_if(half_open_, [&](const auto& other) { return other.get() == &peer; });
  counters_.peers.set(peers_.size());
  inbox_.connected(peer.id);
  return PrefaceStatus::ok;
}

bool TcpListener::make_room() {
  const int64_t now_ns = monotonic_ns();
  const auto silent = std::find_if(peers_.begin(), peers_.end(), [&](const auto& entry) {
    return !entry.second->has_spoken && now_ns - entry.second->greeted_at_ns > kSilentGuestNs;
  });
  if (silent == peers_.end()) return false;
  const std::shared_ptr<Peer> guest = silent->second;
  guest->end(kSilentGuest, Cause::silent);
  return !is_full(peers_.size());
}

std::optional<Cause> TcpListener::received(Peer& peer, FrameKind kind, std::vector<std::byte>&& message) {
  peer.has_spoken = true;
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
      break;  // only listeners send them
  }
  counters_.reject(
      Cause::version);  // a kind of a later version: its length is known, so it can be passed over
  return {};
}

bool TcpListener::hold_back(const Peer& peer) {
  bool full = inbox_.is_full_of_states(peer.id);
  if (options_.delivery == Delivery::all) {
    const Inbox::Waiting waiting = inbox_.waiting(peer.id);
    full = full || waiting.messages >= kMostWaitingMessages || waiting.bytes >= kMostWaitingBytes;
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
    counters_.peers.set(peers_.size());
    return;
  }
  inbox_.note_once(uri_ + ": a connection from " + peer.remote() + " was closed: " + reason);
  std::erase_if(half_open_, [&](const auto& other) { return other.get() == &peer; });
}

void TcpListener::poll(const std::function<void(const LinkEvent&)>& on_event) {
  inbox_.poll(on_event);
  if (!held_back_.exchange(false, std::memory_order_relaxed)) return;
  asio::post(io_, [this] {
    for (const auto& [id, peer] : peers_) peer->resume();
  });
}

void TcpListener::send(PeerId peer, std::span<const std::byte> message) {
  if (message.size() > kMaxMessageBytes) return counters_.reject(Cause::oversize);
  counters_.messages_sent.add();
  counters_.bytes_sent.add(kFrameHeaderBytes + message.size());
  asio::post(io_, [this, peer, copy = std::vector<std::byte>(message.begin(), message.end())] {
    const auto found = peers_.find(peer);
    if (found == peers_.end()) return;
    const std::shared_ptr<Peer> keep = found->second;  // sending may end it
    keep->send(copy);
  });
}

bool TcpListener::send_image(PeerId peer, uint64_t request, std::span<const std::byte> head,
                             size_t pixel_bytes, const FillPixels& fill) {
  const size_t pixels = wire::pixels_at(head.size());
  const size_t bytes = pixels + pixel_bytes;
  // Of all peers together, until it has left.
  if (bytes > kMaxMessageBytes || !image_budget_.take(bytes)) {
    counters_.images_dropped.add();
    return false;
  }
  BudgetedBytes block{{}, BudgetShare(image_budget_, bytes)};
  block.bytes.resize(bytes);
  wire::write_image_block_head(block.bytes, request, head);
  fill(std::span(block.bytes).subspan(pixels));
  counters_.images_sent.add();
  counters_.bytes_sent.add(kFrameHeaderBytes + bytes);
  asio::post(io_, [this, peer, request, block = std::move(block)]() mutable {
    const auto found = peers_.find(peer);
    if (found == peers_.end()) return;
    const std::shared_ptr<Peer> keep = found->second;  // sending may end it
    keep->send_image(request, std::move(block));
  });
  return true;
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options) {
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
  auto listener = std::make_unique<TcpListener>(uri_text(chosen), options, std::move(context));
  if (auto started = listener->start(std::move(*bound)); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::tcp

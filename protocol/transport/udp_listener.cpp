#include "protocol/transport/udp_listener.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <unordered_map>

#include "protocol/transport/address.h"
#include "protocol/transport/clock.h"
#include "protocol/transport/inbox.h"
#include "protocol/transport/random.h"
#include "protocol/transport/udp_cookie.h"
#include "protocol/transport/udp_handshake.h"
#include "protocol/transport/udp_session.h"
#include "protocol/transport/waker.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kPeerTimeoutNs = 10 * kSecondNs;
constexpr int64_t kTickNs = 10 * kMillisecondNs;
constexpr int kBatch = 32;
constexpr int kMostBatchesATurn = 16;
constexpr size_t kMostWaitingPoseBytes = 64 << 20;
constexpr size_t kMostPeerControlBytes = 4 << 20;
constexpr size_t kMostReassemblyBytes = 256 << 20;  // of all peers together
constexpr int kReceiveBufferBytes = 8 << 20;

struct Peer {
  PeerId id = 0;
  uint64_t nonce = 0;
  Address address;
  Session session;
  FrameTracker frames;
};

class UdpListener final : public ListenerLink {
 public:
  UdpListener(std::string uri, const ListenerOptions& options, UniqueFd fd)
      : uri_(std::move(uri)), options_(options), fd_(std::move(fd)), inbox_(counters_) {}
  Result<void> start();
  ~UdpListener() override;

  void poll(const std::function<void(const LinkEvent&)>& on_event) override { inbox_.poll(on_event); }
  void wait(std::chrono::nanoseconds timeout) override { inbox_.wait(timeout); }
  void send(PeerId peer, std::span<const std::byte> message) override;
  LinkStats stats() const override { return counters_.snapshot(); }
  std::string uri() const override { return uri_; }

 private:
  void run();
  void turn(int64_t now_ns);
  void receive_all();
  void handle(const Address& from, std::span<const std::byte> datagram, int64_t now_ns);
  void hello(const Address& from, const Header& header, std::span<const std::byte> datagram, int64_t now_ns);
  void pose(Peer& peer, std::span<const std::byte> payload);
  // False: the peer has to go, for `reason`.
  bool control(Peer& peer, const Header& header, std::span<const std::byte> payload, int64_t now_ns,
               std::string& reason);
  void take_outgoing();
  void emit_due(Peer& peer, int64_t now_ns);
  void end(uint64_t session, const std::string& reason);
  void send_to(const Address& to, std::span<const std::byte> datagram);
  void reject(const std::string& what);

  std::string uri_;
  ListenerOptions options_;
  UniqueFd fd_;
  LinkCounters counters_;
  Inbox inbox_;
  Waker waker_;
  std::thread thread_;
  std::atomic<bool> stop_{false};

  std::mutex outgoing_mutex_;
  std::vector<std::pair<PeerId, std::vector<std::byte>>> outgoing_;

  // On the listener's thread alone.
  Cookies cookies_;
  std::unordered_map<uint64_t, Peer> peers_;  // by session
  std::vector<uint64_t> touched_;             // sessions that may have something to send
  PeerId last_id_ = 0;
};

Result<void> UdpListener::start() {
  if (!waker_) return Error{uri_ + ": out of file descriptors; close some or raise the limit"};
  // A burst of a large frame has to fit; the first call may go above the system's limit, for root alone.
  if (::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUFFORCE, &kReceiveBufferBytes, sizeof kReceiveBufferBytes) !=
      0)
    ::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVBUF, &kReceiveBufferBytes, sizeof kReceiveBufferBytes);
  thread_ = std::thread([this] { run(); });
  return {};
}

UdpListener::~UdpListener() {
  stop_.store(true, std::memory_order_relaxed);
  waker_.wake();
  if (thread_.joinable()) thread_.join();
}

void UdpListener::send(PeerId peer, std::span<const std::byte> message) {
  if (message.size() > kMostPeerControlBytes) {
    counters_.rejected.add();
    return;
  }
  counters_.messages_sent.add();
  {
    const std::lock_guard lock(outgoing_mutex_);
    outgoing_.emplace_back(peer, std::vector<std::byte>(message.begin(), message.end()));
  }
  waker_.wake();
}

// --- the listener's thread
// -------------------------------------------------------------------------------------------

void UdpListener::run() {
  int64_t next_turn = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    try {
      const int64_t now = monotonic_ns();
      const int64_t wait_ns = std::clamp<int64_t>(next_turn - now, 0, kTickNs);
      if (waker_.wait(fd_.get(), POLLIN, static_cast<int>((wait_ns + kMillisecondNs - 1) / kMillisecondNs)) !=
          0)
        receive_all();
      take_outgoing();
      const int64_t after = monotonic_ns();
      if (after >= next_turn) {
        turn(after);
        next_turn = after + kTickNs;
      }
      for (const uint64_t session : touched_)
        if (const auto peer = peers_.find(session); peer != peers_.end()) emit_due(peer->second, after);
      touched_.clear();
    } catch (const std::exception&) {  // no memory: what was being handled is dropped, the others go on
      counters_.rejected.add();
    }
  }
  for (auto& [session, peer] : peers_)
    peer.session.emit_bare(Type::bye, [&](auto datagram) { send_to(peer.address, datagram); });
}

void UdpListener::turn(int64_t now_ns) {
  std::vector<uint64_t> silent;
  for (auto& [session, peer] : peers_) {
    if (now_ns - peer.session.heard_at_ns() > kPeerTimeoutNs)
      silent.push_back(session);
    else
      emit_due(peer, now_ns);
  }
  for (const uint64_t session : silent) end(session, "nothing came from it for 10 seconds");
}

void UdpListener::receive_all() {
  static thread_local std::byte buffers[kBatch][kMaxDatagramBytes + 1];
  Address from[kBatch];
  iovec pieces[kBatch];
  mmsghdr messages[kBatch];
  for (int batch = 0; batch < kMostBatchesATurn; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      pieces[i] = {buffers[i], sizeof buffers[i]};
      messages[i] = {};
      messages[i].msg_hdr.msg_name = from[i].get();
      messages[i].msg_hdr.msg_namelen = sizeof from[i].storage;
      messages[i].msg_hdr.msg_iov = &pieces[i];
      messages[i].msg_hdr.msg_iovlen = 1;
    }
    const int got = ::recvmmsg(fd_.get(), messages, kBatch, MSG_DONTWAIT, nullptr);
    const int64_t now = monotonic_ns();
    for (int i = 0; i < got; ++i) {
      from[i].length = messages[i].msg_hdr.msg_namelen;
      counters_.bytes_received.add(messages[i].msg_len);
      handle(from[i], {buffers[i], messages[i].msg_len}, now);
    }
    if (got < kBatch) return;
  }
}

void UdpListener::reject(const std::string& what) {
  counters_.rejected.add();
  inbox_.note_once(uri_ + ": " + what);
}

void UdpListener::handle(const Address& from, std::span<const std::byte> datagram, int64_t now_ns) {
  Header header;
  if (!read_header(datagram, header))
    return reject("datagrams came that are not FIRE-3DV's; they are dropped");
  if (header.type == Type::hello) return hello(from, header, datagram, now_ns);
  if (header.version != kTransportVersion)
    return reject("datagrams of transport version " + std::to_string(header.version) +
                  " came; use the same version on both sides");
  const auto found = peers_.find(header.session);
  if (found == peers_.end() || !(found->second.address == from)) {
    counters_.rejected.add();
    // Not longer than what came, so that it is of no use for flooding somebody else. A reset is not answered,
    // or two listeners could be made to answer each other for ever.
    if (header.type == Type::reset || header.type == Type::bye || header.type == Type::pong) return;
    std::byte reset[kHeaderBytes];
    write_header(reset, {kTransportVersion, Type::reset, header.session, 0});
    return send_to(from, reset);
  }
  Peer& peer = found->second;
  if (!peer.session.heard(header, now_ns)) return counters_.rejected.add();
  const std::span<const std::byte> payload = datagram.subspan(kHeaderBytes);
  if (header.type == Type::pose) return pose(peer, payload);
  if (header.type == Type::bye) return end(header.session, "the publisher closed the link");
  std::string reason;
  if (!control(peer, header, payload, now_ns, reason)) {
    counters_.rejected.add();
    return end(header.session, reason);
  }
  touched_.push_back(header.session);
}

void UdpListener::hello(const Address& from, const Header& header, std::span<const std::byte> datagram,
                        int64_t now_ns) {
  if (datagram.size() < kHelloBytes) return reject("greetings came that are too short; they are dropped");
  const auto answer = [&](Type type, uint64_t number) {
    send_to(from, write_answer(type, header.session, number));
  };
  if (header.version != kTransportVersion) {
    reject("a publisher speaks transport version " + std::to_string(header.version) +
           ", this program speaks " + std::to_string(kTransportVersion) +
           "; use the same version on both sides");
    return answer(Type::refuse, static_cast<uint64_t>(Refusal::version_mismatch));
  }
  const uint64_t cookie = *read_number(datagram.subspan(kHeaderBytes));
  if (!cookies_.check(cookie, from, header.session, now_ns))
    return answer(Type::cookie, cookies_.make(from, header.session, now_ns));
  // From here on the address is known to be real.
  const auto same = std::find_if(peers_.begin(), peers_.end(),
                                 [&](const auto& entry) { return entry.second.address == from; });
  if (same != peers_.end()) {
    if (same->second.nonce == header.session)
      return answer(Type::accept, same->first);  // our answer was lost
    end(same->first, "the publisher started anew");
  }
  // Peers that left count until their end was polled, or a caller that does not poll would be filled with
  // them.
  if (peers_.size() >= options_.max_peers || inbox_.entries() >= size_t{2} * options_.max_peers) {
    reject("a publisher was refused: as many peers as allowed are connected");
    return answer(Type::refuse, static_cast<uint64_t>(Refusal::full));
  }
  const uint64_t session = random_id();
  peers_.emplace(session, Peer{++last_id_, header.session, from, Session(session, now_ns), {}});
  counters_.peers.set(peers_.size());
  inbox_.connected(last_id_);
  answer(Type::accept, session);
}

void UdpListener::pose(Peer& peer, std::span<const std::byte> payload) {
  PoseHeader header;
  if (!read_pose_header(payload, header)) return counters_.rejected.add();
  const std::span<const std::byte> message = payload.subspan(kPoseHeaderBytes);
  const bool newest = options_.delivery == Delivery::newest;
  if (newest) {
    const auto outcome = peer.frames.part(header.frame, header.part, header.last);
    if (outcome == FrameTracker::Outcome::superseded) return counters_.poses_dropped.add();
    if (outcome == FrameTracker::Outcome::whole) inbox_.drop_parts_before(peer.id, header.frame);
  }
  if (inbox_.waiting(peer.id).bytes > kMostWaitingPoseBytes) {
    // Nobody polls and no frame gets whole: the newest is what is worth keeping.
    if (!newest) return counters_.poses_dropped.add();
    inbox_.drop_parts_before(peer.id, header.frame);
  }
  inbox_.pose_part(peer.id, std::vector<std::byte>(message.begin(), message.end()), header.frame);
}

bool UdpListener::control(Peer& peer, const Header& header, std::span<const std::byte> payload,
                          int64_t now_ns, std::string& reason) {
  size_t budget = kMostReassemblyBytes;
  if (header.type == Type::fragment) {
    size_t held = 0;
    for (auto& [session, other] : peers_) held += other.session.receiver().held_bytes();
    budget -= std::min(held, budget);
  }
  switch (peer.session.control(header, payload, budget, now_ns)) {
    case ControlReceiver::Outcome::complete:
      if (inbox_.control(peer.id, peer.session.receiver().take())) return true;
      reason = "it sent more control messages than were read";
      return false;
    case ControlReceiver::Outcome::corrupt:
      reason = "it sent a damaged control message";
      return false;
    case ControlReceiver::Outcome::ignored:
      counters_.rejected.add();
      return true;
    case ControlReceiver::Outcome::kept:
      return true;
  }
  return true;
}

void UdpListener::take_outgoing() {
  std::vector<std::pair<PeerId, std::vector<std::byte>>> outgoing;
  {
    const std::lock_guard lock(outgoing_mutex_);
    outgoing.swap(outgoing_);
  }
  for (const auto& [id, message] : outgoing) {
    const auto found = std::find_if(peers_.begin(), peers_.end(),
                                    [id = id](const auto& entry) { return entry.second.id == id; });
    if (found == peers_.end()) continue;
    touched_.push_back(found->first);
    if (!found->second.session.sender().push(message, kMostPeerControlBytes)) {
      counters_.rejected.add();
      end(found->first, "it does not acknowledge what is sent to it");
    }
  }
}

void UdpListener::emit_due(Peer& peer, int64_t now_ns) {
  peer.session.emit_due(now_ns,
                        [&](std::span<const std::byte> datagram) { send_to(peer.address, datagram); });
}

void UdpListener::end(uint64_t session, const std::string& reason) {
  const auto found = peers_.find(session);
  if (found == peers_.end()) return;
  found->second.session.emit_bare(Type::bye,
                                  [&](auto datagram) { send_to(found->second.address, datagram); });
  inbox_.disconnected(found->second.id, reason);
  peers_.erase(found);
  counters_.peers.set(peers_.size());
}

void UdpListener::send_to(const Address& to, std::span<const std::byte> datagram) {
  // What does not go out now is repeated like what is lost on the way.
  const ssize_t sent =
      ::sendto(fd_.get(), datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to.get(), to.length);
  if (sent > 0) counters_.bytes_sent.add(static_cast<uint64_t>(sent));
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options) {
  auto bound = bind_listener(uri, SOCK_DGRAM, options.insecure);
  if (!bound) return bound.error();
  Uri chosen = uri;
  chosen.port = bound->address.port();
  auto listener = std::make_unique<UdpListener>(uri_text(chosen), options, std::move(bound->fd));
  if (auto started = listener->start(); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::udp

#include "protocol/transport/udp_listener.h"

#include <algorithm>
#include <mutex>
#include <unordered_map>

#include "protocol/transport/address.h"
#include "protocol/transport/clock.h"
#include "protocol/transport/network_listener.h"
#include "protocol/transport/random.h"
#include "protocol/transport/udp_cookie.h"
#include "protocol/transport/udp_group_listener.h"
#include "protocol/transport/udp_group_socket.h"
#include "protocol/transport/udp_handshake.h"
#include "protocol/transport/udp_receive.h"
#include "protocol/transport/udp_session.h"
#include "protocol/transport/udp_states.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kPeerTimeoutNs = 10 * kSecondNs;
constexpr int64_t kTickNs = 10 * kMillisecondNs;
constexpr size_t kMostPeerControlBytes = 4 << 20;

struct Peer {
  PeerId id = 0;  // 0 until it is a peer: a sealed session has to show that it has the key's seal
  uint64_t nonce = 0;
  Address address;
  Session session;
  std::vector<std::byte> accept;  // our answer, should it be lost
  FrameTracker frames;
  uint64_t told_frame = 0;  // the newest whole frame that we told it of
  int64_t came_at_ns = 0;
  int64_t spoke_at_ns = 0;  // when a pose or a piece of a control message came
  std::shared_ptr<PeerBudget> budget;
  BudgetCharge pieces;  // of control messages that are not whole
};

class UdpListener final : public NetworkListener {
 public:
  UdpListener(const Uri& uri, const ListenerOptions& options, UniqueFd fd,
              std::shared_ptr<const PreSharedKey> key)
      : NetworkListener(uri_text(uri), options),
        fd_(std::move(fd)),
        key_(std::move(key)),
        most_datagram_bytes_(uri.mtu != 0 ? uri.mtu : kMaxDatagramBytes) {}
  Result<void> start();
  ~UdpListener() override { thread_.stop(); }

  void send(PeerId peer, std::span<const std::byte> message) override;

 private:
  void run();
  void turn(int64_t now_ns);
  void handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns);
  void hello(const Address& from, const Header& header, std::span<const std::byte> datagram, int64_t now_ns);
  void make_room(int64_t now_ns);
  void refuse(const Address& to, uint64_t nonce, Refusal refusal, uint64_t more = 0);
  bool has_place_for(const Peer& peer) const;
  void welcome(Peer& peer);
  // A cause: the peer has to go, for `reason`.
  std::optional<Cause> control(Peer& peer, const Header& header, std::span<const std::byte> payload,
                               int64_t now_ns, std::string& reason);
  std::optional<Cause> states(Peer& peer, std::string& reason);
  void take_outgoing();
  void emit_due(Peer& peer, int64_t now_ns);
  void end(uint64_t session, const std::string& reason);
  void send_to(const Address& to, std::span<const std::byte> datagram);

  const UniqueFd fd_;
  const std::shared_ptr<const PreSharedKey> key_;  // null: unsealed
  const size_t most_datagram_bytes_;

  std::mutex outgoing_mutex_;
  std::vector<std::pair<PeerId, ControlSender::Prepared>> outgoing_;

  // On the listener's thread alone.
  Cookies cookies_;
  std::unordered_map<uint64_t, Peer> peers_;  // by session
  size_t welcomed_ = 0;                       // of them
  std::vector<uint64_t> touched_;             // sessions that may have something to send
};

Result<void> UdpListener::start() {
  widen_receive_buffer(fd_.get());
  return thread_.start(uri_, [this] { run(); });
}

void UdpListener::send(PeerId peer, std::span<const std::byte> message) {
  if (message.size() > kMostPeerControlBytes) return counters_.reject(Cause::oversize);
  counters_.messages_sent.add();
  ControlSender::Prepared prepared = ControlSender::prepare(message);
  {
    const std::lock_guard lock(outgoing_mutex_);
    outgoing_.emplace_back(peer, std::move(prepared));
  }
  thread_.wake();
}

// --- the listener's thread

void UdpListener::run() {
  int64_t next_turn = 0;
  while (!thread_.stopping()) {
    try {
      const int64_t now = monotonic_ns();
      if (thread_.wait(fd_.get(), POLLIN, std::clamp<int64_t>(next_turn - now, 0, kTickNs)) != 0)
        receive_all(fd_.get(), counters_,
                    [this](auto& from, auto datagram, int64_t at_ns) { handle(from, datagram, at_ns); });
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
      counters_.reject(Cause::no_memory);
    }
  }
  for (auto& [session, peer] : peers_)
    peer.session.emit_bare(Type::bye, [&, &to = peer.address](auto datagram) { send_to(to, datagram); });
}

void UdpListener::turn(int64_t now_ns) {
  std::vector<uint64_t> silent;
  for (auto& [session, peer] : peers_) {
    if (now_ns - peer.session.heard_at_ns() > kPeerTimeoutNs) {
      silent.push_back(session);
      continue;
    }
    emit_due(peer, now_ns);
    if (peer.frames.newest_whole() == peer.told_frame) continue;
    peer.told_frame = peer.frames.newest_whole();
    peer.session.emit_number(Type::have, peer.told_frame,
                             [&, &to = peer.address](auto datagram) { send_to(to, datagram); });
  }
  for (const uint64_t session : silent) {
    counters_.reject(Cause::silent);
    end(session, "nothing came from it for 10 seconds");
  }
}

void UdpListener::handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns) {
  Header header;
  if (!read_header(datagram, header))
    return reject(Cause::malformed, "datagrams came that are not FIRE-3DV's; they are dropped");
  if (header.type == Type::hello) return hello(from, header, datagram, now_ns);
  if (header.version != kTransportVersion)
    return reject(Cause::version, "datagrams of transport version " + std::to_string(header.version) +
                                      " came; use the same version on both sides");
  const auto found = peers_.find(header.session);
  if (found == peers_.end() || !(found->second.address == from)) {
    counters_.reject(Cause::unknown_session);
    // Not longer than what came, so that it is of no use for flooding somebody else. A reset is not answered,
    // or two listeners could be made to answer each other for ever.
    if (header.type == Type::reset || header.type == Type::bye || header.type == Type::pong) return;
    std::byte reset[kHeaderBytes];
    write_header(reset, {kTransportVersion, Type::reset, header.session, 0});
    return send_to(from, reset);
  }
  Peer& peer = found->second;
  std::span<const std::byte> payload;
  switch (peer.session.hear(header, datagram, now_ns, payload)) {
    case Session::Heard::repeated:
      return counters_.reject(Cause::replayed);
    case Session::Heard::forged:
      return reject(Cause::bad_key, "datagrams came that are not sealed with our key; they are dropped");
    case Session::Heard::too_long:
      return reject(Cause::oversize,
                    "datagrams came that are longer than their publisher said; they are dropped");
    case Session::Heard::payload:
      break;
  }
  if (peer.id == 0) {
    if (!has_place_for(peer)) {
      reject(Cause::full, "a publisher was refused: as many peers as allowed are connected");
      return end(header.session, "as many peers as allowed are connected");
    }
    welcome(peer);
  }
  if (header.type == Type::pose) {
    peer.spoke_at_ns = now_ns;
    const auto arrival = take_pose(inbox_, counters_, options_.delivery, peer.id, peer.frames, payload);
    if (arrival == PoseArrival::repeated)
      peer.told_frame = 0;  // it may not have heard that we have the frame
    return;
  }
  if (header.type == Type::bye) return end(header.session, "the publisher closed the link");
  std::string reason;
  if (const auto cause = control(peer, header, payload, now_ns, reason)) {
    counters_.reject(*cause);
    return end(header.session, reason);
  }
  touched_.push_back(header.session);
}

void UdpListener::refuse(const Address& to, uint64_t nonce, Refusal refusal, uint64_t more) {
  send_to(to, write_answer(Type::refuse, nonce, more << 16 | static_cast<uint64_t>(refusal)));
}

void UdpListener::hello(const Address& from, const Header& header, std::span<const std::byte> datagram,
                        int64_t now_ns) {
  if (datagram.size() < kHelloBytes)
    return reject(Cause::malformed, "greetings came that are too short; they are dropped");
  if (header.version != kTransportVersion) {
    reject(Cause::version, "a publisher speaks transport version " + std::to_string(header.version) +
                               ", this program speaks " + std::to_string(kTransportVersion) +
                               "; use the same version on both sides");
    return refuse(from, header.session, Refusal::version_mismatch);
  }
  const HelloFields fields = read_hello(datagram);
  if (!cookies_.check(fields.cookie, from, header.session, now_ns))
    return send_to(from,
                   write_answer(Type::cookie, header.session, cookies_.make(from, header.session, now_ns)));
  // From here on the address is known to be real.
  if (fields.sealed != (key_ != nullptr) || (key_ && !proves_key(datagram, fields, *key_))) {
    reject(Cause::bad_key, "a publisher was refused: " +
                               std::string(!key_           ? "it has a key, and this renderer was given none"
                                           : fields.sealed ? "it has another key"
                                                           : "it has no key") +
                               "; give both sides the same key file");
    return refuse(from, header.session, Refusal::bad_key);
  }
  const size_t datagram_bytes = fields.datagram_bytes != 0 ? fields.datagram_bytes : kDatagramBytes;
  if (datagram_bytes < kLeastDatagramBytes || datagram_bytes > most_datagram_bytes_) {
    reject(Cause::oversize, "a publisher was refused: its datagrams have " + std::to_string(datagram_bytes) +
                                " bytes, and at most " + std::to_string(most_datagram_bytes_) +
                                " are taken here; choose ?mtu= accordingly on both sides");
    return refuse(from, header.session, Refusal::datagram_bytes, most_datagram_bytes_);
  }
  std::vector<uint64_t> earlier;
  for (const auto& [session, peer] : peers_) {
    if (!(peer.address == from)) continue;
    if (peer.nonce == header.session) return send_to(from, peer.accept);  // our answer was lost
    // A sealed peer goes only when the new session has shown its seal: this hello may be a recording.
    if (!key_ || peer.id == 0) earlier.push_back(session);
  }
  for (const uint64_t session : earlier) end(session, "the publisher started anew");
  const bool starts_anew = peers_.size() != 0 && key_ &&
                           std::any_of(peers_.begin(), peers_.end(),
                                       [&](const auto& entry) { return entry.second.address == from; });
  if (is_full(welcomed_) && !starts_anew) make_room(now_ns);
  if ((is_full(welcomed_) && !starts_anew) || peers_.size() >= size_t{2} * options_.max_peers) {
    reject(Cause::full, "a publisher was refused: as many peers as allowed are connected");
    return refuse(from, header.session, Refusal::full);
  }
  const uint64_t session = random_id();
  const Random random = key_ ? make_random() : Random{};
  std::unique_ptr<Seal> seal;
  if (key_) seal = key_->make_seal(PreSharedKey::Side::listener, session, fields.random, random);
  std::vector<std::byte> accept =
      write_accept(header.session, session, fields.random, random, key_.get(), fields.datagram_bytes);
  Peer& peer = peers_
                   .emplace(session, Peer{0,
                                          header.session,
                                          from,
                                          Session(session, now_ns, std::move(seal), datagram_bytes),
                                          std::move(accept),
                                          {}})
                   .first->second;
  peer.came_at_ns = peer.spoke_at_ns = now_ns;
  if (!key_) welcome(peer);
  send_to(from, peer.accept);
}

void UdpListener::make_room(int64_t now_ns) {
  auto silent = peers_.end();
  for (auto peer = peers_.begin(); peer != peers_.end(); ++peer) {
    if (silent != peers_.end() && silent->second.spoke_at_ns <= peer->second.spoke_at_ns) continue;
    if (may_lose_place(peer->second.id, peer->second.came_at_ns, peer->second.spoke_at_ns, now_ns))
      silent = peer;
  }
  if (silent == peers_.end()) return;
  counters_.reject(Cause::silent);
  end(silent->first, kSilentGuest);
}

// Several sealed sessions may begin while one place is free. The first one that shows its seal gets it.
bool UdpListener::has_place_for(const Peer& peer) const {
  const auto replaced = std::count_if(peers_.begin(), peers_.end(), [&](const auto& entry) {
    return entry.second.id != 0 && entry.second.address == peer.address;
  });
  return replaced != 0 || !is_full(welcomed_);
}

void UdpListener::welcome(Peer& peer) {
  std::vector<uint64_t> earlier;
  for (const auto& [session, other] : peers_)
    if (&other != &peer && other.address == peer.address) earlier.push_back(session);
  for (const uint64_t session : earlier) end(session, "the publisher started anew");
  peer.id = ++last_id_;
  counters_.peers.set(++welcomed_);
  peer.budget = connected(peer.id, peer.address.text());
}

std::optional<Cause> UdpListener::control(Peer& peer, const Header& header,
                                          std::span<const std::byte> payload, int64_t now_ns,
                                          std::string& reason) {
  // Not acknowledged, it comes again, when what waits has been polled.
  if (header.type == Type::state && inbox_.is_full_of_states(peer.id)) return {};
  const auto held_bytes = [&] {
    return peer.session.receiver().held_bytes() + peer.session.state_receiver().held_bytes();
  };
  const size_t most = peer.budget->limit(Resource::received_bytes);
  const auto outcome = peer.session.control(header, payload, most - std::min(held_bytes(), most), now_ns);
  if (header.type == Type::fragment || header.type == Type::state) peer.spoke_at_ns = now_ns;
  if (outcome == ControlReceiver::Outcome::kept) {
    const Result<void> charged = charge_in_steps(peer.pieces, peer.budget, held_bytes());
    if (charged) return {};
    reason = charged.error().message;
    return Cause::no_memory;
  }
  switch (outcome) {
    case ControlReceiver::Outcome::complete: {
      peer.pieces.release();  // the inbox charges the whole message
      if (header.type == Type::state) return states(peer, reason);
      const auto cause = inbox_.control(peer.id, peer.session.receiver().take());
      if (cause) reason = refusal_text(peer.id, *cause);
      return cause;
    }
    case ControlReceiver::Outcome::corrupt:
      reason = "it sent a damaged control message";
      return Cause::malformed;
    case ControlReceiver::Outcome::ignored:
      counters_.reject(Cause::malformed);
      return {};
    case ControlReceiver::Outcome::kept:
      return {};
  }
  return {};
}

std::optional<Cause> UdpListener::states(Peer& peer, std::string& reason) {
  auto messages = open_bundle(peer.session.state_receiver().take());
  if (!messages) {
    reason = "it sent a damaged bundle of scene edits";
    return Cause::malformed;
  }
  for (auto& message : *messages) {
    const auto cause = inbox_.state(peer.id, std::move(message));
    if (!cause) continue;
    reason = refusal_text(peer.id, *cause);
    return cause;
  }
  return {};
}

void UdpListener::take_outgoing() {
  std::vector<std::pair<PeerId, ControlSender::Prepared>> outgoing;
  {
    const std::lock_guard lock(outgoing_mutex_);
    outgoing.swap(outgoing_);
  }
  for (auto& [id, message] : outgoing) {
    const auto found = std::find_if(peers_.begin(), peers_.end(),
                                    [id = id](const auto& entry) { return entry.second.id == id; });
    if (found == peers_.end()) continue;
    touched_.push_back(found->first);
    if (!found->second.session.sender().push(std::move(message), kMostPeerControlBytes)) {
      counters_.reject(Cause::unread);
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
  Peer& peer = found->second;
  peer.session.emit_bare(Type::bye, [&](auto datagram) { send_to(peer.address, datagram); });
  if (peer.id != 0) {
    inbox_.disconnected(peer.id, reason);
    counters_.peers.set(--welcomed_);
  }
  peers_.erase(found);
}

void UdpListener::send_to(const Address& to, std::span<const std::byte> datagram) {
  // What does not go out now is repeated like what is lost on the way.
  const ssize_t sent =
      ::sendto(fd_.get(), datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to.get(), to.length);
  if (sent > 0) counters_.bytes_sent.add(static_cast<uint64_t>(sent));
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options) {
  if (const auto group = group_of(uri)) return make_group_listener(uri, *group, options);
  if (auto sound = refuse_group_options(uri); !sound) return sound.error();
  std::shared_ptr<const PreSharedKey> key;
  if (!options.key_file.empty()) {
    auto read = PreSharedKey::from_file(options.key_file);
    if (!read) return Error{uri_text(uri) + ": " + read.error().message};
    key = *read;
  }
  auto bound = bind_listener(uri, SOCK_DGRAM, options.insecure || key != nullptr);
  if (!bound) return bound.error();
  Uri chosen = uri;
  chosen.port = bound->address.port();
  auto listener = std::make_unique<UdpListener>(chosen, options, std::move(bound->fd), std::move(key));
  if (auto started = listener->start(); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::udp

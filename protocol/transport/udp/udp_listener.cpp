#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/random.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/udp/udp_control.h"
#include "protocol/transport/udp/udp_group_socket.h"
#include "protocol/transport/udp/udp_handshake.h"
#include "protocol/transport/udp/udp_peers.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kPeerTimeoutNs = 10 * kSecondNs;
constexpr int64_t kTickNs = 10 * kMillisecondNs;
constexpr size_t kMaxPeerControlBytes = 4 << 20;
constexpr int64_t kMuteNs = 4 * kSecondNs;

class UdpListener final : public NetworkListener {
 public:
  UdpListener(const Uri& uri, const ListenerOptions& options, UniqueFd fd,
              std::shared_ptr<const PreSharedKey> key)
      : NetworkListener(uri_text(uri), options),
        fd_(std::move(fd)),
        key_(std::move(key)),
        acceptor_(key_ ? std::make_unique<Acceptor>(key_, size_t{2} * options.max_peers, acceptor_events())
                       : nullptr),
        max_datagram_bytes_(uri.mtu != 0 ? uri.mtu : kMaxDatagramBytes),
        wants_parity_(uri.parity_percent != 0) {}
  Result<void> start();
  ~UdpListener() override { thread_.stop(); }

  void send(PeerId peer, std::span<const std::byte> message) override;
  bool carries_input() const override { return key_ != nullptr; }  // else anyone could forge them

 private:
  void run();
  void tick(int64_t now_ns);
  void handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns);
  void handle_sealed(const Address& from, std::span<std::byte> datagram, int64_t now_ns);
  // Processes a datagram of a peer's session.
  void handle_payload(uint64_t session, Peer& peer, Session::Received received, Type type,
                      std::span<const std::byte> payload, int64_t now_ns);
  void reset(const Address& to, uint64_t session);
  void note_black_hole(Peer& peer, int64_t now_ns);
  void note_shorter_datagrams(const Peer& newcomer);
  void note_late_records(Peer& peer);

  void hello(const Address& from, const Header& header, std::span<const std::byte> datagram, int64_t now_ns);
  // Returns false if the record does not belong to the pending session.
  bool sealed_hello(const Address& from, std::span<std::byte> datagram, const RecordDatagram& about,
                    int64_t now_ns);
  Acceptor::Events acceptor_events();
  // Reason to refuse a publisher with this datagram length, if any.
  std::optional<Refusal> refusal(const Address& from, size_t datagram_bytes, int64_t now_ns);
  void refuse_key(const Address& from, uint64_t nonce, const char* reason);
  void refuse_version(const Address& from, uint64_t nonce, const std::string& spoken);
  void make_room(int64_t now_ns);
  void refuse(const Address& to, uint64_t nonce, Refusal refusal, uint64_t more = 0);
  Peer& add_peer(uint64_t session, Peer&& newcomer, int64_t now_ns);
  // Returns a cause if the peer must be disconnected for `reason`.
  std::optional<Cause> control(Peer& peer, Type type, std::span<const std::byte> payload, int64_t now_ns,
                               std::string& reason);
  std::optional<Cause> states(Peer& peer, std::string& reason);
  void take_outgoing();
  void emit_due(Peer& peer, int64_t now_ns);
  void end(uint64_t session, const std::string& reason);
  void send_to(const Address& to, std::span<const std::byte> datagram);

  const UniqueFd fd_;
  const std::shared_ptr<const PreSharedKey> key_;  // null: unsealed
  const std::unique_ptr<Acceptor> acceptor_;       // null: unsealed; used on the listener's thread only
  const size_t max_datagram_bytes_;
  const bool wants_parity_;  // false: reports no receipts, so that publishers send none

  std::mutex outgoing_mutex_;
  std::vector<std::pair<PeerId, ControlSender::Prepared>> outgoing_;

  // Used on the listener's thread only.
  Cookies cookies_;
  PeerTable peers_;
  std::vector<uint64_t> touched_;  // sessions that may have something to send
};

Result<void> UdpListener::start() {
  widen_receive_buffer(fd_.get());
  return thread_.start(uri_, [this] { run(); });
}

void UdpListener::send(PeerId peer, std::span<const std::byte> message) {
  if (message.size() > kMaxPeerControlBytes) return counters_.reject(Cause::oversize);
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
  int64_t next_tick = 0;
  while (!thread_.stopping()) {
    try {
      const int64_t now = monotonic_ns();
      if (thread_.wait(fd_.get(), POLLIN, std::clamp<int64_t>(next_tick - now, 0, kTickNs)) != 0)
        receive_all(fd_.get(), counters_,
                    [this](auto& from, auto datagram, int64_t at_ns) { handle(from, datagram, at_ns); });
      take_outgoing();
      const int64_t after = monotonic_ns();
      if (after >= next_tick) {
        tick(after);
        next_tick = after + kTickNs;
      }
      for (const uint64_t session : touched_)
        if (Peer* const peer = peers_.find(session)) emit_due(*peer, after);
      touched_.clear();
    } catch (const std::exception&) {  // out of memory: drops the current datagram only
      counters_.reject(Cause::no_memory);
    }
  }
  for (auto& [session, peer] : peers_)
    peer.session.emit_bare(Type::bye, [&, &to = peer.address](auto datagram) { send_to(to, datagram); });
}

void UdpListener::tick(int64_t now_ns) {
  if (acceptor_) acceptor_->tick(now_ns);
  std::vector<uint64_t> silent;
  for (auto& [session, peer] : peers_) {
    if (now_ns - peer.session.last_received_ns() > kPeerTimeoutNs) {
      silent.push_back(session);
      continue;
    }
    emit_due(peer, now_ns);
    note_black_hole(peer, now_ns);
    const bool owes_receipt = wants_parity_ && peer.owes_receipt(now_ns);
    if (peer.poses.frames.newest_whole() == peer.acknowledged_frame && !owes_receipt) continue;
    peer.acknowledged_frame = peer.poses.frames.newest_whole();
    peer.reported = peer.session.receipt();
    peer.reported_at_ns = now_ns;
    const auto emit = [&, &to = peer.address](auto datagram) { send_to(to, datagram); };
    if (wants_parity_)
      peer.session.emit_have(peer.acknowledged_frame, emit);
    else
      peer.session.emit_number(Type::have, peer.acknowledged_frame, emit);
  }
  for (const uint64_t session : silent) {
    counters_.reject(Cause::silent);
    end(session, "nothing came from it for 10 seconds");
  }
}

// A publisher of an older version, which does not look for shorter datagrams itself.
void UdpListener::note_black_hole(Peer& peer, int64_t now_ns) {
  if (peer.is_mute_noted || peer.has_any_message() || now_ns - peer.connected_at_ns < kMuteNs) return;
  peer.is_mute_noted = true;
  if (peer.session.receipt().received == 0) return;
  const std::string bytes = std::to_string(peer.session.datagram_bytes());
  inbox_.note({}, "mute publisher",
              "a publisher at " + peer.address.text() +
                  " answers, and nothing of its description arrives: its " + "datagrams of " + bytes +
                  " bytes are lost on the way; use ?mtu=576 there, or tcp://");
}

void UdpListener::note_shorter_datagrams(const Peer& newcomer) {
  const size_t bytes = newcomer.session.datagram_bytes();
  for (const auto& [session, peer] : peers_) {
    if (!peer.address.is_same_host(newcomer.address) || peer.has_any_message() ||
        peer.session.datagram_bytes() <= bytes)
      continue;
    inbox_.note({}, "shorter datagrams " + std::to_string(bytes),
                "datagrams of " + std::to_string(peer.session.datagram_bytes()) + " bytes from " +
                    newcomer.address.text() + " are lost on the way; its publisher goes on with " +
                    std::to_string(bytes) + " (?mtu=" + std::to_string(bytes) +
                    " in its URI begins with them)");
    return end(session, "the publisher was restarted");
  }
}

// OpenSSL's window cannot be widened: jitter that lets more records pass loses the late ones.
void UdpListener::note_late_records(Peer& peer) {
  constexpr uint64_t kMany = 64;
  if (++peer.late_records != kMany) return;
  inbox_.note({}, "late records",
              "sealed datagrams from " + peer.address.text() + " come after " +
                  std::to_string(kRecordWindow) +
                  " newer ones, and are lost for it; use tls://, or fewer and longer datagrams (?mtu=)");
}

void UdpListener::handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns) {
  Header header;
  if (!read_header(datagram, header)) return handle_sealed(from, datagram, now_ns);
  if (header.type == Type::hello) return hello(from, header, datagram, now_ns);
  if (header.version != kTransportVersion)
    return reject(Cause::version, "datagrams of transport version " + std::to_string(header.version) +
                                      " came; use the same version on both sides");
  Peer* const peer = peers_.find(header.session);
  if (peer == nullptr || peer->session.sealed() || !(peer->address == from)) {
    counters_.reject(Cause::unknown_session);
    // Never answers a reset: two listeners would otherwise answer each other endlessly.
    if (header.type == Type::reset || header.type == Type::bye || header.type == Type::pong) return;
    return reset(from, header.session);
  }
  std::span<const std::byte> payload;
  const auto received = peer->session.receive(header, datagram, now_ns, payload);
  handle_payload(header.session, *peer, received, header.type, payload, now_ns);
}

// Not longer than the request: no amplification towards a spoofed address.
void UdpListener::reset(const Address& to, uint64_t session) {
  std::byte bytes[kHeaderBytes];
  write_header(bytes, {kTransportVersion, Type::reset, session, 0});
  send_to(to, bytes);
}

void UdpListener::handle_sealed(const Address& from, std::span<std::byte> datagram, int64_t now_ns) {
  using Kind = RecordDatagram::Kind;
  const RecordDatagram about = inspect_records(datagram);
  Peer* const known = peers_.find_at(from);
  Peer* const peer = known != nullptr && known->session.sealed() ? known : nullptr;
  if (about.kind == Kind::client_hello) {
    if (!key_) return refuse_key(from, about.nonce, "it has a key, and this renderer was given none");
    if (peer != nullptr && peer->nonce == about.nonce) return counters_.reject(Cause::replayed);
    const auto outcome = acceptor_->client_hello(from, about, datagram, now_ns);
    if (outcome == Acceptor::Outcome::busy) counters_.reject(Cause::full);
    if (outcome == Acceptor::Outcome::malformed) counters_.reject(Cause::malformed);
  } else if (about.kind == Kind::handshake && acceptor_ && acceptor_->has(from)) {
    if (acceptor_->handshake(from, about, datagram) == Acceptor::Outcome::busy) counters_.reject(Cause::full);
  } else if (about.kind == Kind::handshake) {
    counters_.reject(peer != nullptr ? Cause::replayed : Cause::unknown_session);
    if (peer != nullptr)
      peer->session.repeat_handshake(datagram, [&](auto answer) { send_to(peer->address, answer); });
  } else if (about.kind == Kind::data) {
    // While a publisher reconnects, records of both sessions may arrive from its address.
    if (acceptor_ && acceptor_->established(from) != nullptr && sealed_hello(from, datagram, about, now_ns))
      return;
    if (peer == nullptr) {
      counters_.reject(Cause::unknown_session);
      if (!acceptor_ || !acceptor_->has(from)) reset(from, about.record_number);
      return;
    }
    Type type{};
    std::span<const std::byte> payload;
    const auto received = peer->session.open(about, datagram, now_ns, type, payload);
    if (received == Session::Received::repeated && peer->session.is_late(about)) note_late_records(*peer);
    handle_payload(peers_.session_at(from), *peer, received, type, payload, now_ns);
  } else {
    reject(Cause::malformed, "datagrams came that are not FIRE-3DV's; they are dropped");
  }
}

void UdpListener::handle_payload(uint64_t session, Peer& peer, Session::Received received, Type type,
                                 std::span<const std::byte> payload, int64_t now_ns) {
  switch (received) {
    case Session::Received::repeated:
      return counters_.reject(Cause::replayed);
    case Session::Received::forged:
      return reject(Cause::bad_key, "datagrams came that are not sealed with our key; they are dropped");
    case Session::Received::too_long:
      return reject(Cause::oversize, "datagrams came that are longer than announced; they are dropped");
    case Session::Received::payload:
      break;
  }
  if (type == Type::hello && peer.session.sealed()) {  // our answer was lost
    const Parameters parameters{.datagram_bytes = static_cast<uint16_t>(peer.session.datagram_bytes())};
    return peer.session.emit_number(Type::accept, parameters_number(parameters),
                                    [&](auto answer) { send_to(peer.address, answer); });
  }
  if (type == Type::pose) {
    peer.last_message_ns = now_ns;
    peer.has_poses = true;
    const auto arrival = deliver_pose(inbox_, counters_, options_.delivery, peer.id, peer.poses, payload);
    if (arrival == PoseArrival::repeated)
      peer.acknowledged_frame = 0;  // the acknowledgment may have been lost
    return charge_or_clear(peer.parity, peer.budget, peer.poses.parity);
  }
  if (type == Type::parity) {
    deliver_parity(inbox_, counters_, options_.delivery, peer.id, peer.poses, payload);
    return charge_or_clear(peer.parity, peer.budget, peer.poses.parity);
  }
  if (type == Type::bye) return end(session, "the publisher closed the link");
  std::string reason;
  if (const auto cause = control(peer, type, payload, now_ns, reason)) {
    counters_.reject(*cause);
    return end(session, reason);
  }
  touched_.push_back(session);
}

// --- handshakes

void UdpListener::refuse(const Address& to, uint64_t nonce, Refusal refusal, uint64_t more) {
  send_to(to, write_answer(Type::refuse, nonce, refusal_number(refusal, more)));
}

void UdpListener::refuse_key(const Address& from, uint64_t nonce, const char* reason) {
  reject(Cause::bad_key,
         std::string("a publisher was refused: ") + reason + "; give both sides the same key file");
  refuse(from, nonce, Refusal::bad_key);
}

void UdpListener::refuse_version(const Address& from, uint64_t nonce, const std::string& spoken) {
  reject(Cause::version, "a publisher speaks " + spoken + ", this program speaks " +
                             std::to_string(kTransportVersion) + "; use the same version on both sides");
  refuse(from, nonce, Refusal::version_mismatch);
}

std::optional<Refusal> UdpListener::refusal(const Address& from, size_t datagram_bytes, int64_t now_ns) {
  if (datagram_bytes < kLeastDatagramBytes || datagram_bytes > max_datagram_bytes_) {
    reject(Cause::oversize, "a publisher was refused: its datagrams have " + std::to_string(datagram_bytes) +
                                " bytes, and at most " + std::to_string(max_datagram_bytes_) +
                                " are taken here; choose ?mtu= accordingly on both sides");
    return Refusal::datagram_bytes;
  }
  const bool is_reconnect = peers_.session_at(from) != 0;
  if (is_full(peers_.size()) && !is_reconnect) make_room(now_ns);
  if (is_full(peers_.size()) && !is_reconnect) {
    reject(Cause::full, "a publisher was refused: as many peers as allowed are connected");
    return Refusal::full;
  }
  return {};
}

void UdpListener::hello(const Address& from, const Header& header, std::span<const std::byte> datagram,
                        int64_t now_ns) {
  if (datagram.size() < kHelloBytes)
    return reject(Cause::malformed, "greetings came that are too short; they are dropped");
  if (header.version != kTransportVersion)
    return refuse_version(from, header.session, "transport version " + std::to_string(header.version));
  const HelloFields fields = read_hello(datagram);
  if (!cookies_.check(fields.cookie, from, header.session, now_ns))
    return send_to(from,
                   write_answer(Type::cookie, header.session, cookies_.make(from, header.session, now_ns)));
  // The cookie proves that the address is not spoofed.
  if (key_) return refuse_key(from, header.session, "it has no key");
  if (fields.mode != 0)
    return refuse_key(from, header.session, "it has a key, and this renderer was given none");
  if (const Peer* const known = peers_.find_at(from); known != nullptr && known->nonce == header.session)
    return send_to(from, known->accept);  // our answer was lost
  const size_t datagram_bytes = fields.datagram_bytes != 0 ? fields.datagram_bytes : kDatagramBytes;
  if (const auto refused = refusal(from, datagram_bytes, now_ns))
    return refuse(from, header.session, *refused,
                  *refused == Refusal::datagram_bytes ? max_datagram_bytes_ : 0);
  const uint64_t session = random_id();
  const Peer& peer = add_peer(session,
                              {0, header.session, from, Session(session, now_ns, nullptr, datagram_bytes),
                               write_accept(header.session, session, fields.datagram_bytes)},
                              now_ns);
  send_to(from, peer.accept);
}

// First record after a completed handshake: the parameters. Only this authenticated record makes the session
// a peer and ends an earlier one of the address: all earlier datagrams may be replayed or spoofed.
bool UdpListener::sealed_hello(const Address& from, std::span<std::byte> datagram,
                               const RecordDatagram& about, int64_t now_ns) {
  Dtls& dtls = *acceptor_->established(from);
  const auto answer = [&](Type type, uint64_t number) { send_to(from, seal_number(dtls, type, number)); };
  const auto message = open_number(dtls, about, datagram);
  if (!message) return false;
  if (message->type != Type::hello) {
    counters_.reject(Cause::malformed);
    return true;
  }
  const Parameters parameters = read_parameters(message->number);
  if (parameters.version != kTransportVersion || parameters.mode != Parameters::kSealedMode) {
    reject(Cause::version, "a publisher speaks transport version " + std::to_string(parameters.version) +
                               ", this program speaks " + std::to_string(kTransportVersion) +
                               "; use the same version on both sides");
    answer(Type::refuse, refusal_number(Refusal::version_mismatch));
    acceptor_->drop(from);
    return true;
  }
  if (const auto refused = refusal(from, parameters.datagram_bytes, now_ns)) {
    answer(Type::refuse,
           refusal_number(*refused, *refused == Refusal::datagram_bytes ? max_datagram_bytes_ : 0));
    acceptor_->drop(from);
    return true;
  }
  Acceptor::Established established = acceptor_->extract(from);
  const uint64_t session = random_id();
  Peer& peer = add_peer(session,
                        {0,
                         established.nonce,
                         from,
                         Session(session, now_ns, std::move(established.dtls), parameters.datagram_bytes),
                         {}},
                        now_ns);
  peer.session.emit_number(Type::accept, parameters_number(parameters),
                           [&](auto bytes) { send_to(from, bytes); });
  return true;
}

Acceptor::Events UdpListener::acceptor_events() {
  return {.send = [this](const Address& to, auto datagram) { send_to(to, datagram); },
          .failed =
              [this](const Address& from, uint64_t nonce, std::optional<Refusal> refusal) {
                if (refusal == Refusal::bad_key) return refuse_key(from, nonce, "it has another key");
                if (refusal == Refusal::version_mismatch)
                  return refuse_version(from, nonce, "another transport version");
                reject(Cause::malformed, "a handshake failed; it is dropped");
              },
          .silent = [this] { counters_.reject(Cause::silent); }};
}

void UdpListener::make_room(int64_t now_ns) {
  auto silent = peers_.end();
  for (auto peer = peers_.begin(); peer != peers_.end(); ++peer) {
    if (silent != peers_.end() && silent->second.last_message_ns <= peer->second.last_message_ns) continue;
    if (may_evict(peer->second.id, peer->second.connected_at_ns, peer->second.last_message_ns, now_ns))
      silent = peer;
  }
  if (silent == peers_.end()) return;
  counters_.reject(Cause::silent);
  end(silent->first, kEvictionReason);
}

Peer& UdpListener::add_peer(uint64_t session, Peer&& newcomer, int64_t now_ns) {
  if (const uint64_t earlier = peers_.session_at(newcomer.address); earlier != 0)
    end(earlier, "the publisher was restarted");
  note_shorter_datagrams(newcomer);
  Peer& peer = peers_.add(session, std::move(newcomer));
  peer.connected_at_ns = peer.last_message_ns = now_ns;
  peer.id = ++last_id_;
  counters_.peers.set(peers_.size());
  peer.budget = connected(peer.id, peer.address.text());
  return peer;
}

std::optional<Cause> UdpListener::control(Peer& peer, Type type, std::span<const std::byte> payload,
                                          int64_t now_ns, std::string& reason) {
  // An unacknowledged state is repeated later, after the queued ones have been polled.
  if (type == Type::state && inbox_.is_full_of_states(peer.id)) return {};
  const auto buffered_bytes = [&] {
    return peer.session.receiver().buffered_bytes() + peer.session.state_receiver().buffered_bytes();
  };
  const size_t most = peer.budget->limit(Resource::received_bytes);
  const auto outcome = peer.session.control(type, payload, most - std::min(buffered_bytes(), most), now_ns);
  if (type == Type::fragment || type == Type::state) peer.last_message_ns = now_ns;
  if (outcome == ControlReceiver::Outcome::accepted) {
    const Result<void> charged = charge_in_steps(peer.pieces, peer.budget, buffered_bytes());
    if (charged) return {};
    reason = charged.error().message;
    return Cause::no_memory;
  }
  switch (outcome) {
    case ControlReceiver::Outcome::complete: {
      peer.pieces.release();  // the inbox charges the whole message
      if (type == Type::state) return states(peer, reason);
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
    case ControlReceiver::Outcome::accepted:
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
    const uint64_t session = peers_.session_of(id);
    Peer* const peer = peers_.find(session);
    if (peer == nullptr) continue;
    touched_.push_back(session);
    if (!peer->session.sender().push(std::move(message), kMaxPeerControlBytes)) {
      counters_.reject(Cause::unread);
      end(session, "it does not acknowledge its replies");
    }
  }
}

void UdpListener::emit_due(Peer& peer, int64_t now_ns) {
  peer.session.emit_due(now_ns,
                        [&](std::span<const std::byte> datagram) { send_to(peer.address, datagram); });
}

void UdpListener::end(uint64_t session, const std::string& reason) {
  Peer* const peer = peers_.find(session);
  if (peer == nullptr) return;
  peer->session.emit_bare(Type::bye, [&](auto datagram) { send_to(peer->address, datagram); });
  inbox_.disconnected(peer->id, reason);
  peers_.remove(session);
  counters_.peers.set(peers_.size());
}

void UdpListener::send_to(const Address& to, std::span<const std::byte> datagram) {
  // A datagram that the socket rejects is repeated later, like a lost one.
  const ssize_t sent =
      ::sendto(fd_.get(), datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to.get(), to.length);
  if (sent > 0) counters_.bytes_sent.add(static_cast<uint64_t>(sent));
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_listener(const Uri& uri, const ListenerOptions& options) {
  if (const auto group = group_of(uri)) return make_group_listener(uri, *group, options);
  if (auto sound = refuse_group_options(uri); !sound) return sound.error();
  auto key = PreSharedKey::from_file(options.key_file, uri);
  if (!key) return key.error();
  auto bound = bind_listener(uri, SOCK_DGRAM, options.insecure || *key != nullptr);
  if (!bound) return bound.error();
  Uri chosen = uri;
  chosen.port = bound->address.port();
  auto listener = std::make_unique<UdpListener>(chosen, options, std::move(bound->fd), std::move(*key));
  if (auto started = listener->start(); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::udp

#include "protocol/transport/core/link_factories.h"

#include <algorithm>
#include <list>

#include "base/clock.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/udp/multicast/udp_group.h"
#include "protocol/transport/udp/udp_group_socket.h"
#include "protocol/transport/udp/udp_poses.h"
#include "protocol/transport/udp/udp_session.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kGroupPeerTimeoutNs = 10 * kSecondNs;
constexpr size_t kMaxUnpolledMessages = 128;
constexpr int64_t kGroupTickNs = 100 * kMillisecondNs;

struct GroupPeer {
  PeerId id = 0;
  Address address;
  size_t datagram_bytes = 0;
  Session session;  // id, replay window, time of the last datagram
  CarouselReceiver control;
  ReceivedPoses poses;
  std::shared_ptr<PeerBudget> budget;
  BudgetCharge pieces, parity;  // fragments of incomplete control messages; parts and parity of frames
};

class GroupListener final : public NetworkListener {
 public:
  GroupListener(const Uri& uri, const ListenerOptions& options, UniqueFd fd)
      : NetworkListener(uri_text(uri), options),
        fd_(std::move(fd)),
        max_datagram_bytes_(uri.mtu != 0 ? uri.mtu : kMaxDatagramBytes) {}
  Result<void> start();
  ~GroupListener() override { thread_.stop(); }

  // A multicast group has no back channel.
  void send(PeerId, std::span<const std::byte>) override {}

 private:
  using Peers = std::list<GroupPeer>;  // one for each publisher of the group

  void run();
  void end_silent(int64_t now_ns);
  void handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns);
  Peers::iterator find(const Header& header, const Address& from);
  Peers::iterator add_peer(const Header& header, const Address& from, std::span<const std::byte> datagram,
                           int64_t now_ns);
  // Returns a cause if the peer must be disconnected for `reason`.
  std::optional<Cause> control(GroupPeer& peer, const Header& header, std::span<const std::byte> payload,
                               std::string& reason);
  void end(Peers::iterator peer, const std::string& reason);

  const UniqueFd fd_;
  const size_t max_datagram_bytes_;
  Peers peers_;  // used on the listener's thread only
};

Result<void> GroupListener::start() {
  widen_receive_buffer(fd_.get());
  return thread_.start(uri_, [this] { run(); });
}

void GroupListener::run() {
  while (!thread_.stopping()) {
    try {
      if (thread_.wait(fd_.get(), POLLIN, kGroupTickNs) != 0)
        receive_all(fd_.get(), counters_,
                    [this](const Address& from, std::span<std::byte> datagram, int64_t at_ns) {
                      handle(from, datagram, at_ns);
                    });
      end_silent(monotonic_ns());
    } catch (const std::exception&) {  // out of memory: drops the current datagram only
      counters_.reject(Cause::no_memory);
    }
  }
}

void GroupListener::end_silent(int64_t now_ns) {
  for (auto peer = peers_.begin(); peer != peers_.end();) {
    const auto current = peer++;
    if (now_ns - current->session.last_received_ns() <= kGroupPeerTimeoutNs) continue;
    counters_.reject(Cause::silent);
    end(current, "nothing came from it for 10 seconds");
  }
}

GroupListener::Peers::iterator GroupListener::find(const Header& header, const Address& from) {
  return std::find_if(peers_.begin(), peers_.end(), [&](const GroupPeer& peer) {
    return peer.session.id() == header.session && peer.address == from;
  });
}

void GroupListener::handle(const Address& from, std::span<std::byte> datagram, int64_t now_ns) {
  Header header;
  if (!read_header(datagram, header))
    return reject(Cause::malformed, "datagrams came that are not FIRE-3DV's; they are dropped");
  if (header.version != kTransportVersion)
    return reject(Cause::version, "datagrams of transport version " + std::to_string(header.version) +
                                      " came; use the same version on both sides");
  auto peer = find(header, from);
  if (peer == peers_.end()) {
    // Joined within a round; the next round begins with an offer.
    if (header.type == Type::pose || header.type == Type::parity)
      return counters_.poses_dropped.add(header.type == Type::pose);
    if (header.type != Type::group) return counters_.reject(Cause::unknown_session);
    peer = add_peer(header, from, datagram, now_ns);
    if (peer == peers_.end()) return;
  }
  std::span<const std::byte> payload;
  switch (peer->session.receive(header, datagram, now_ns, payload)) {
    case Session::Received::repeated:
      return counters_.reject(Cause::replayed);
    case Session::Received::too_long:
      return reject(Cause::oversize, "datagrams came that are longer than announced; they are dropped");
    case Session::Received::forged:
    case Session::Received::payload:
      break;
  }
  if (header.type == Type::pose || header.type == Type::parity) {
    if (!peer->control.described()) return counters_.poses_dropped.add(header.type == Type::pose);
    if (header.type == Type::pose)
      deliver_pose(inbox_, counters_, options_.delivery, peer->id, peer->poses, payload);
    else
      deliver_parity(inbox_, counters_, options_.delivery, peer->id, peer->poses, payload);
    charge_or_clear(peer->parity, peer->budget, peer->poses.parity);
    return;
  }
  if (header.type == Type::bye) return end(peer, "the publisher closed the link");
  std::string reason;
  if (const auto cause = control(*peer, header, payload, reason)) {
    counters_.reject(*cause);
    end(peer, reason);
  }
}

GroupListener::Peers::iterator GroupListener::add_peer(const Header& header, const Address& from,
                                                       std::span<const std::byte> datagram, int64_t now_ns) {
  GroupOffer offer;
  if (!read_group_offer(datagram.subspan(kHeaderBytes), offer)) {
    counters_.reject(Cause::malformed);
    return peers_.end();
  }
  if (offer.datagram_bytes > max_datagram_bytes_) {
    reject(Cause::oversize, "a publisher was refused: its datagrams have " +
                                std::to_string(offer.datagram_bytes) + " bytes, and at most " +
                                std::to_string(max_datagram_bytes_) +
                                " are taken here; choose ?mtu= accordingly on both sides");
    return peers_.end();
  }
  if (is_full(peers_.size())) {
    reject(Cause::full, "a publisher was refused: as many peers as allowed are connected");
    return peers_.end();
  }
  const size_t datagram_bytes = offer.datagram_bytes;
  peers_.push_back({++last_id_,
                    from,
                    datagram_bytes,
                    Session(header.session, now_ns, nullptr, datagram_bytes),
                    CarouselReceiver(fragment_bytes_of(datagram_bytes)),
                    {}});
  counters_.peers.set(peers_.size());
  peers_.back().budget = connected(peers_.back().id, from.text());
  return std::prev(peers_.end());
}

std::optional<Cause> GroupListener::control(GroupPeer& peer, const Header& header,
                                            std::span<const std::byte> payload, std::string& reason) {
  if (header.type == Type::group) {
    GroupOffer offer;
    reason = "it contradicts itself";
    if (!read_group_offer(payload, offer) || offer.datagram_bytes != peer.datagram_bytes)
      return Cause::malformed;
    if (const uint32_t gone = peer.control.offered(offer)) counters_.reject(Cause::lapped, gone);
  } else if (FragmentHeader fragment;
             header.type == Type::fragment && read_fragment_header(payload, fragment)) {
    const size_t most = peer.budget->limit(Resource::received_bytes);
    const size_t room = most - std::min(peer.control.buffered_bytes(), most);
    const auto outcome = peer.control.fragment(fragment, payload.subspan(kFragmentHeaderBytes), room);
    if (auto charged = charge_in_steps(peer.pieces, peer.budget, peer.control.buffered_bytes()); !charged) {
      reason = charged.error().message;
      return Cause::no_memory;
    }
    switch (outcome) {
      case CarouselReceiver::Outcome::accepted:
        break;
      case CarouselReceiver::Outcome::ignored:
        counters_.reject(Cause::malformed);
        break;
      case CarouselReceiver::Outcome::corrupt:
        reason = "it sent a damaged control message";
        return Cause::malformed;
    }
  } else {
    counters_.reject(Cause::malformed);
  }
  // A new receiver may have all messages at once: the rest waits until these are polled.
  while (inbox_.waiting(peer.id).messages < kMaxUnpolledMessages) {
    auto message = peer.control.take();
    if (!message) break;
    if (const auto cause = inbox_.control(peer.id, std::move(*message))) {
      reason = refusal_text(peer.id, *cause);
      return cause;
    }
  }
  return {};
}

void GroupListener::end(Peers::iterator peer, const std::string& reason) {
  inbox_.disconnected(peer->id, reason);
  peers_.erase(peer);
  counters_.peers.set(peers_.size());
}

}  // namespace

Result<std::unique_ptr<ListenerLink>> make_group_listener(const Uri& uri, const Address& group,
                                                          const ListenerOptions& options) {
  const std::string name = uri_text(uri);
  if (!options.key_file.empty())
    return Error{name +
                 ": datagrams to a group cannot be sealed; leave the key away, or listen on an address of "
                 "this machine"};
  if (!options.insecure)
    return Error{name +
                 ": anyone on the network can send to a group; use --insecure if that is wanted, or "
                 "listen on an address of this machine with a key"};
  if (uri.port == 0) return Error{name + ": a group's port is known to all who join it; name one"};
  Result<UniqueFd> fd = open_group_receiver(uri, group);
  if (!fd) return fd.error();
  auto listener = std::make_unique<GroupListener>(uri, options, std::move(*fd));
  if (auto started = listener->start(); !started) return started.error();
  return std::unique_ptr<ListenerLink>(std::move(listener));
}

}  // namespace fire3dv::transport::udp

#include "tools/lab/impair/relay.h"

#include <poll.h>

#include <algorithm>
#include <queue>
#include <vector>

#include "base/clock.h"

namespace fire3dv::impair {

using fire3dv::monotonic_ns;
using transport::Address;

Result<std::unique_ptr<Relay>> open_relay(const std::string& from, const std::string& to,
                                          const Impairment& impairment, bool may_be_public) {
  using Scheme = transport::Uri::Scheme;
  const auto from_uri = transport::parse_uri(from);
  if (!from_uri) return from_uri.error();
  const auto to_uri = transport::parse_uri(to);
  if (!to_uri) return to_uri.error();
  if (from_uri->scheme == Scheme::shm || to_uri->scheme == Scheme::shm)
    return Error{"shared memory uses no network: name udp://, tcp:// or tls:// addresses"};
  if ((from_uri->scheme == Scheme::udp) != (to_uri->scheme == Scheme::udp))
    return Error{from + " and " + to + ": name two URIs of one kind, datagrams or streams"};
  if (to_uri->port == 0) return Error{to + ": port 0 is for listeners; name the target's port"};
  const auto open = [&](auto opened) -> Result<std::unique_ptr<Relay>> {
    if (!opened) return opened.error();
    return std::unique_ptr<Relay>(std::move(*opened));
  };
  if (from_uri->scheme == Scheme::udp) return open(UdpRelay::open(from, to, impairment, may_be_public));
  return open(TcpRelay::open(from, to, impairment, may_be_public));
}

Result<RelayEnds> open_ends(const std::string& from, const std::string& to, int type, bool may_be_public) {
  auto from_uri = transport::parse_uri(from);
  if (!from_uri) return from_uri.error();
  const auto to_uri = transport::parse_uri(to);
  if (!to_uri) return to_uri.error();
  const transport::Lookup lookup(*to_uri);
  if (!lookup.done()) return Error{to + ": name the target by its address, in digits"};
  auto bound = transport::bind_listener(*from_uri, type, may_be_public);
  if (!bound) return bound.error();
  from_uri->port = bound->address.port();
  return RelayEnds{transport::uri_text(*from_uri), std::move(bound->fd), lookup.addresses().front()};
}

namespace {

constexpr size_t kMaxClients = 256;

struct Waiting {
  int64_t due_ns = 0;
  uint64_t order = 0;
  size_t client = 0;
  bool to_target = false;
  std::vector<std::byte> datagram;
  bool operator>(const Waiting& other) const {
    return due_ns != other.due_ns ? due_ns > other.due_ns : order > other.order;
  }
};

struct Client {
  Address address;
  UniqueFd to_target;  // connected socket, so that answers reach their client
};

}  // namespace

struct UdpRelay::State {
  UniqueFd front;
  Address target;
  std::vector<Client> clients;

  mutable std::mutex mutex;  // protects the following members
  Impairment impairment;
  bool seeded = false;
  DatagramChannel channels[2];  // from the target, to the target
  RelayCounts counts;
  Filter filter;

  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting;
  uint64_t order = 0;

  void take(size_t client, bool to_target, std::span<std::byte> datagram, int64_t now_ns);
  void deliver(int64_t now_ns);
  size_t client_of(const Address& from);
};

void UdpRelay::State::take(size_t client, bool to_target, std::span<std::byte> datagram, int64_t now_ns) {
  const std::lock_guard lock(mutex);
  const bool filtered = filter && !filter(to_target, datagram);
  const DatagramChannel::Fate fate = channels[to_target].draw(impairment, datagram.size(), now_ns);
  if (filtered || fate.copies == 0) {
    ++counts.lost;
    return;
  }
  counts.reordered += fate.overtakes;
  counts.duplicated += fate.copies == 2;
  for (int copy = 0; copy < fate.copies; ++copy)
    waiting.push({fate.due_ns, ++order, client, to_target, {datagram.begin(), datagram.end()}});
}

void UdpRelay::State::deliver(int64_t now_ns) {
  while (!waiting.empty() && waiting.top().due_ns <= now_ns) {
    const Waiting& next = waiting.top();
    const Client& client = clients[next.client];
    if (next.to_target)
      ::send(client.to_target.get(), next.datagram.data(), next.datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    else
      ::sendto(front.get(), next.datagram.data(), next.datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
               client.address.get(), client.address.length);
    const size_t bytes = next.datagram.size();
    waiting.pop();
    const std::lock_guard lock(mutex);
    ++counts.passed;
    counts.passed_bytes += bytes;
  }
}

size_t UdpRelay::State::client_of(const Address& from) {
  for (size_t i = 0; i < clients.size(); ++i)
    if (clients[i].address == from) return i;
  if (clients.size() == kMaxClients) return kMaxClients;
  Client client;
  client.address = from;
  client.to_target = UniqueFd(::socket(target.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!client.to_target || ::connect(client.to_target.get(), target.get(), target.length) != 0)
    return kMaxClients;
  clients.push_back(std::move(client));
  return clients.size() - 1;
}

Result<std::unique_ptr<UdpRelay>> UdpRelay::open(const std::string& from, const std::string& to,
                                                 const Impairment& impairment, bool may_be_public) {
  auto ends = open_ends(from, to, SOCK_DGRAM, may_be_public);
  if (!ends) return ends.error();
  std::unique_ptr<UdpRelay> relay(new UdpRelay);
  relay->uri_ = std::move(ends->uri);
  relay->state_ = std::make_unique<State>();
  relay->state_->front = std::move(ends->front);
  const int buffer = 8 << 20;
  ::setsockopt(relay->state_->front.get(), SOL_SOCKET, SO_RCVBUFFORCE, &buffer, sizeof buffer);
  relay->state_->target = ends->target;
  relay->set(impairment);
  if (auto started = relay->thread_.start(relay->uri_, [self = relay.get()] { self->run(); }); !started)
    return started.error();
  return relay;
}

UdpRelay::~UdpRelay() {
  thread_.stop();
}

void UdpRelay::set(const Impairment& impairment) {
  const std::lock_guard lock(state_->mutex);
  // Each direction has its own random numbers, so that answers do not change the fate of requests.
  if (!state_->seeded || state_->impairment.seed != impairment.seed)
    for (uint64_t way = 0; way < 2; ++way) state_->channels[way] = DatagramChannel(2 * impairment.seed + way);
  state_->seeded = true;
  state_->impairment = impairment;
}

void UdpRelay::set_filter(Filter filter) {
  const std::lock_guard lock(state_->mutex);
  state_->filter = std::move(filter);
}

RelayCounts UdpRelay::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

void UdpRelay::run() {
  State& state = *state_;
  std::byte buffer[65536];
  std::vector<pollfd> polled;
  while (!thread_.stopping()) {
    polled.assign(1, {state.front.get(), POLLIN, 0});
    for (const Client& client : state.clients) polled.push_back({client.to_target.get(), POLLIN, 0});
    const int64_t wait_ns =
        state.waiting.empty()
            ? 10'000'000
            : std::clamp<int64_t>(state.waiting.top().due_ns - monotonic_ns(), 0, 10'000'000);
    const timespec timeout{0, static_cast<long>(wait_ns)};
    ::ppoll(polled.data(), polled.size(), &timeout, nullptr);
    for (size_t i = 1; i < polled.size(); ++i) {
      ssize_t got;
      while ((got = ::recv(polled[i].fd, buffer, sizeof buffer, MSG_DONTWAIT)) >= 0)
        state.take(i - 1, false, {buffer, static_cast<size_t>(got)}, monotonic_ns());
    }
    for (int i = 0; i < 1024; ++i) {
      Address from;
      from.length = sizeof from.storage;
      const ssize_t got =
          ::recvfrom(state.front.get(), buffer, sizeof buffer, MSG_DONTWAIT, from.get(), &from.length);
      if (got < 0) break;
      const size_t client = state.client_of(from);
      if (client < kMaxClients) state.take(client, true, {buffer, static_cast<size_t>(got)}, monotonic_ns());
    }
    state.deliver(monotonic_ns());
  }
}

}  // namespace fire3dv::impair

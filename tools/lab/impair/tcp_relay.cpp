#include "tools/lab/impair/relay.h"

#include <netinet/tcp.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <deque>
#include <vector>

#include "base/clock.h"
#include "tools/lab/impair/impairment.h"

namespace fire3dv::impair {

using fire3dv::monotonic_ns;
using transport::Address;

namespace {

constexpr size_t kMaxConnections = 256;
constexpr size_t kMaxWaitingBytes = 1 << 20;         // per direction; beyond it the sender must wait
constexpr int64_t kLongestTcpQueueNs = 200'000'000;  // limit for rate-limited links
constexpr size_t kSegmentBytes = 1448;
constexpr int64_t kPollNs = 10'000'000;  // poll period for events that poll() does not report, such as
                                         // the end of an outage

struct Segment {
  int64_t due_ns = 0;
  std::vector<std::byte> bytes;
  size_t sent = 0;
};

// One direction of one connection.
struct Way {
  Way(const Impairment& impairment, uint64_t connection, bool to_target)
      : fate(impairment, connection, to_target) {}

  StreamImpairment fate;
  std::deque<Segment> waiting;
  size_t waiting_bytes = 0;
  int64_t free_at_ns = 0;  // when the rate-limited link has sent its queue
  int64_t last_due_ns = 0;
  bool ended = false;   // the source sends no more
  bool closed = false;  // the destination has been notified

  bool has_room(int64_t now_ns) const {
    return !ended && waiting_bytes < kMaxWaitingBytes && free_at_ns - now_ns < kLongestTcpQueueNs;
  }
  bool is_due(int64_t now_ns) const { return !waiting.empty() && waiting.front().due_ns <= now_ns; }
};

struct Connection {
  Connection(const Impairment& impairment, uint64_t number)
      : ways{Way(impairment, number, false), Way(impairment, number, true)} {}

  UniqueFd ends[2];  // client socket, target socket
  Way ways[2];       // towards the client, towards the target
  bool broken = false;
};

// A rate-limited link must have a short queue; a large kernel buffer would model another network.
void limit_buffers(const UniqueFd& end, const Impairment& impairment) {
  const int bytes = 16 << 10;
  if (impairment.bits_per_second != 0) ::setsockopt(end.get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

// Closes with a reset and discards unsent data.
void reset(UniqueFd& end) {
  const linger at_once{1, 0};
  ::setsockopt(end.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  end = UniqueFd();
}

}  // namespace

struct TcpRelay::State {
  UniqueFd front;
  Address target;
  std::vector<Connection> connections;
  std::vector<std::byte> buffer = std::vector<std::byte>(kSegmentBytes);

  mutable std::mutex mutex;  // protects the following members
  Impairment impairment;
  RelayCounts counts;

  void accept_all();
  void take(Connection& connection, int way, int64_t now_ns);
  void deliver(Connection& connection, int way, int64_t now_ns);
  void pump(int64_t now_ns);
};

void TcpRelay::State::accept_all() {
  UniqueFd client;
  while ((client = UniqueFd(::accept4(front.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)))) {
    if (connections.size() == kMaxConnections) continue;
    Connection connection(impairment, counts.connections++);
    connection.ends[0] = std::move(client);
    connection.ends[1] = UniqueFd(::socket(target.family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int on = 1;
    for (const UniqueFd& end : connection.ends) {
      ::setsockopt(end.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      limit_buffers(end, impairment);
    }
    connection.broken =
        ::connect(connection.ends[1].get(), target.get(), target.length) != 0 && errno != EINPROGRESS;
    connections.push_back(std::move(connection));
  }
}

void TcpRelay::State::take(Connection& connection, int index, int64_t now_ns) {
  Way& way = connection.ways[index];
  while (way.has_room(now_ns) && !connection.broken) {
    const size_t most = std::min<uint64_t>(buffer.size(), way.fate.quiet_bytes());
    const ssize_t got = ::recv(connection.ends[1 - index].get(), buffer.data(), most, MSG_DONTWAIT);
    if (got < 0) {
      connection.broken = errno != EAGAIN && errno != EINTR;
      return;
    }
    if (got == 0) {
      way.ended = true;
      return;
    }
    const auto bytes = static_cast<size_t>(got);
    counts.bytes += bytes;
    const bool stalls = way.fate.pass(bytes);
    if (way.fate.is_reset()) {
      ++counts.resets;
      connection.broken = true;
      return;
    }
    int64_t sent_ns = now_ns;
    if (impairment.bits_per_second != 0) {
      sent_ns = way.free_at_ns = std::max(way.free_at_ns, now_ns) +
                                 static_cast<int64_t>(bytes * 8 * 1'000'000'000 / impairment.bits_per_second);
    }
    // Segments keep their order, whatever the jitter.
    way.last_due_ns = std::max(way.last_due_ns, sent_ns + way.fate.delay_ns(impairment));
    way.waiting.push_back({way.last_due_ns, {buffer.begin(), buffer.begin() + got}, 0});
    way.waiting_bytes += bytes;
    if (stalls) {
      ++counts.stalls;
      way.last_due_ns += impairment.stall_ns;
    }
  }
}

void TcpRelay::State::deliver(Connection& connection, int index, int64_t now_ns) {
  Way& way = connection.ways[index];
  while (way.is_due(now_ns) && !connection.broken) {
    Segment& next = way.waiting.front();
    const ssize_t sent = ::send(connection.ends[index].get(), next.bytes.data() + next.sent,
                                next.bytes.size() - next.sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) {
      connection.broken = errno != EAGAIN && errno != EINTR;
      return;
    }
    next.sent += static_cast<size_t>(sent);
    if (next.sent < next.bytes.size()) return;
    way.waiting_bytes -= next.bytes.size();
    way.waiting.pop_front();
  }
  if (way.ended && way.waiting.empty() && !way.closed) {
    ::shutdown(connection.ends[index].get(), SHUT_WR);
    way.closed = true;
  }
}

void TcpRelay::State::pump(int64_t now_ns) {
  const std::lock_guard lock(mutex);
  if (impairment.down) return;
  accept_all();
  for (Connection& connection : connections) {
    for (const int way : {0, 1}) take(connection, way, now_ns);
    for (const int way : {0, 1}) deliver(connection, way, now_ns);
    if (connection.broken)
      for (UniqueFd& end : connection.ends) reset(end);
  }
  std::erase_if(connections, [](const Connection& connection) {
    return connection.broken || (connection.ways[0].closed && connection.ways[1].closed);
  });
}

Result<std::unique_ptr<TcpRelay>> TcpRelay::open(const std::string& from, const std::string& to,
                                                 const Impairment& impairment, bool may_be_public) {
  auto ends = open_ends(from, to, SOCK_STREAM, may_be_public);
  if (!ends) return ends.error();
  std::unique_ptr<TcpRelay> relay(new TcpRelay);
  relay->uri_ = std::move(ends->uri);
  relay->state_ = std::make_unique<State>();
  relay->state_->front = std::move(ends->front);
  limit_buffers(relay->state_->front, impairment);
  relay->state_->target = ends->target;
  relay->set(impairment);
  if (auto started = relay->thread_.start(relay->uri_, [self = relay.get()] { self->run(); }); !started)
    return started.error();
  return relay;
}

TcpRelay::~TcpRelay() {
  thread_.stop();
}

void TcpRelay::set(const Impairment& impairment) {
  const std::lock_guard lock(state_->mutex);
  state_->impairment = impairment;
}

RelayCounts TcpRelay::counts() const {
  const std::lock_guard lock(state_->mutex);
  return state_->counts;
}

void TcpRelay::run() {
  State& state = *state_;
  std::vector<pollfd> polled;
  while (!thread_.stopping()) {
    int64_t now_ns = monotonic_ns(), wake_ns = now_ns + kPollNs;
    polled.clear();
    const bool down = [&] {
      const std::lock_guard lock(state.mutex);
      return state.impairment.down;
    }();
    if (!down) polled.push_back({state.front.get(), POLLIN, 0});
    for (const Connection& connection : state.connections) {
      for (const int end : {0, 1}) {
        const Way& in = connection.ways[1 - end];
        const Way& out = connection.ways[end];
        const auto events =
            static_cast<short>((in.has_room(now_ns) ? POLLIN : 0) | (out.is_due(now_ns) ? POLLOUT : 0));
        // Ends without requested events are skipped, since poll() would report a hang-up repeatedly.
        if (events != 0 && !down) polled.push_back({connection.ends[end].get(), events, 0});
        if (!out.waiting.empty() && !out.is_due(now_ns))
          wake_ns = std::min(wake_ns, out.waiting.front().due_ns);
      }
    }
    const timespec timeout{0, static_cast<long>(std::clamp<int64_t>(wake_ns - now_ns, 0, kPollNs))};
    ::ppoll(polled.data(), polled.size(), &timeout, nullptr);
    state.pump(monotonic_ns());
  }
}

}  // namespace fire3dv::impair

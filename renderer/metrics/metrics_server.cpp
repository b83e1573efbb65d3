#include "renderer/metrics/metrics_server.h"

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <utility>

#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/http/accept_loop.h"
#include "protocol/transport/http/deadline.h"
#include "renderer/metrics/request_reader.h"

namespace fire3dv::metrics {
namespace {

using boost::asio::ip::tcp;
using ErrorCode = boost::system::error_code;

constexpr uint16_t kExamplePort = 9464;
constexpr size_t kMaxConnections = 32;
// From accept to the end of the response. A scrape on loopback takes milliseconds.
constexpr std::chrono::seconds kMaxVisitTime{5};
constexpr size_t kMaxDrainedBytes = 1 << 20;

class Connection;

// State that the connections share, on the server's thread.
struct Visits {
  MetricsServer::Page page;
  std::map<uint64_t, Connection*> open;  // by age, oldest first
  uint64_t next_number = 0;
  std::map<unsigned, uint64_t> answered{{200, 0}, {400, 0}, {404, 0},
                                        {405, 0}, {431, 0}, {505, 0}};  // by status
  uint64_t timed_out = 0, evicted = 0;

  std::string write_page() const;
};

std::string Visits::write_page() const {
  Exposition exposition;
  page(exposition);
  exposition.family("fire3dv_metrics_requests_total", "counter", "Requests to this page, by answer.");
  for (const auto& [status, count] : answered) exposition.sample({{"code", std::to_string(status)}}, count);
  exposition.family("fire3dv_metrics_sent_away_total", "counter",
                    "Connections to this page that were closed without an answer.");
  exposition.sample({{"cause", "slow"}}, timed_out);
  exposition.sample({{"cause", "full"}}, evicted);
  return exposition.text();
}

// HTTP connection of one scraper: one request, one response, close.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Visits& visits)
      : visits_(visits),
        number_(visits.next_number++),
        socket_(std::move(socket)),
        deadline_(socket_.get_executor()) {
    visits_.open.emplace(number_, this);
  }
  ~Connection() { visits_.open.erase(number_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool is_answered() const { return is_answered_; }
  void start() {
    deadline_.set(kMaxVisitTime, weak_from_this(), [](Connection& self) {
      if (!self.is_answered_) ++self.visits_.timed_out;
      self.close();
    });
    read();
  }
  void close() {
    ErrorCode ignored;
    deadline_.cancel();
    socket_.close(ignored);
  }

 private:
  void read() {
    socket_.async_read_some(boost::asio::buffer(bytes_),
                            [self = shared_from_this()](ErrorCode error, size_t count) {
                              if (!error) self->on_read(count);
                            });
  }
  void on_read(size_t count) {
    const std::optional<unsigned> status = request_.add({bytes_.data(), count});
    if (!status) return read();
    ++visits_.answered.at(*status);
    response_ = make_response(*status, *status == 200 ? visits_.write_page() : std::string());
    boost::beast::http::async_write(socket_, response_, [self = shared_from_this()](ErrorCode error, size_t) {
      if (error) return;
      self->is_answered_ = true;
      ErrorCode ignored;
      self->socket_.shutdown(tcp::socket::shutdown_send, ignored);
      self->drain();
    });
  }
  // Reads what the client still sends: a reset could overtake the response.
  void drain() {
    socket_.async_read_some(boost::asio::buffer(bytes_),
                            [self = shared_from_this()](ErrorCode error, size_t count) {
                              self->drained_bytes_ += count;
                              if (!error && self->drained_bytes_ < kMaxDrainedBytes) self->drain();
                            });
  }

  Visits& visits_;
  const uint64_t number_;
  tcp::socket socket_;
  transport::http::Deadline deadline_;
  RequestReader request_;
  Response response_;
  std::array<char, 2048> bytes_;
  size_t drained_bytes_ = 0;
  bool is_answered_ = false;
};

}  // namespace

struct MetricsServer::State final : transport::http::ConnectionOwner {
  Visits visits;  // outlives the accept loop, whose handlers own the connections
  std::unique_ptr<transport::http::AcceptLoop> loop;
  transport::LinkThread thread;

  size_t open_connections() const override { return visits.open.size(); }
  void evict() override {
    const auto oldest = visits.open.begin();
    visits.evicted += oldest->second->is_answered() ? 0 : 1;
    oldest->second->close();
    visits.open.erase(oldest);
  }
  void serve(tcp::socket&& socket) override {
    std::make_shared<Connection>(std::move(socket), visits)->start();
  }
};

MetricsServer::MetricsServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

MetricsServer::~MetricsServer() {
  state_->loop->stop();
  state_->thread.stop();
}

Result<std::unique_ptr<MetricsServer>> MetricsServer::open(const std::string& at, bool insecure, Page page) {
  auto state = std::make_unique<State>();
  state->visits.page = std::move(page);
  transport::http::ListenOptions listen;
  listen.at = at;
  listen.option = "--metrics";
  listen.example_port = kExamplePort;
  listen.may_be_public = insecure;
  listen.risk = "anyone on the network could read the metrics there";
  listen.max_connections = kMaxConnections;
  auto loop = transport::http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
  std::unique_ptr<MetricsServer> server(new MetricsServer(std::move(state)));
  State* const raw = server->state_.get();
  if (auto started = raw->thread.start("--metrics " + at, [raw] { raw->loop->run(); }); !started)
    return started.error();
  return server;
}

std::string MetricsServer::address() const {
  return state_->loop->address();
}

}  // namespace fire3dv::metrics

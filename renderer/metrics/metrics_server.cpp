#include "renderer/metrics/metrics_server.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/http/session.h"

namespace fire3dv::metrics {
namespace {

namespace http = transport::http;

constexpr uint16_t kExamplePort = 9464;
constexpr size_t kMaxConnections = 32;

}  // namespace

struct MetricsServer::State final : http::SessionOwner {
  explicit State(Page current)
      : SessionOwner({std::numeric_limits<uint64_t>::max(), 1}), page(std::move(current)) {
    for (const unsigned status : {200, 400, 403, 404, 405, 408, 421, 431, 505}) answered[status] = 0;
  }

  const Page page;
  std::unique_ptr<http::AcceptLoop> loop;
  transport::LinkThread thread;

  std::string write_page() const;
  void set_access(http::AccessRules&& rules) { access = std::move(rules); }
  void on_header(http::Session& session) override {
    constexpr const char* kPlain = "text/plain; charset=utf-8";
    const auto target = session.request().target();
    if (!std::all_of(target.begin(), target.end(), [](char c) { return c >= 0x20 && c <= 0x7e; }))
      return session.answer(refusal(400, "the target has bytes that are not ASCII"));
    if (session.request().method() != boost::beast::http::verb::get)
      return session.answer({405, kPlain, "use GET\n", {{"Allow", "GET"}}});
    // Scrapers may add query parameters; they are ignored.
    if (session.path() != "/metrics") return session.answer({404, kPlain, "metrics are at /metrics\n"});
    session.answer({200, "text/plain; version=0.0.4; charset=utf-8", write_page()});
  }
};

std::string MetricsServer::State::write_page() const {
  Exposition exposition;
  page(exposition);
  exposition.family("fire3dv_metrics_requests_total", "counter", "Requests to this page, by answer.");
  for (const auto& [status, count] : answered)
    exposition.sample({{"code", std::to_string(status)}}, count + (status == 200 ? 1 : 0));  // with this one
  exposition.family("fire3dv_metrics_sent_away_total", "counter",
                    "Connections to this page that were closed without an answer.");
  exposition.sample({{"cause", "slow"}}, timed_out);
  exposition.sample({{"cause", "full"}}, evicted);
  return exposition.text();
}

MetricsServer::MetricsServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

MetricsServer::~MetricsServer() {
  state_->loop->stop();
  state_->thread.stop();
}

Result<std::unique_ptr<MetricsServer>> MetricsServer::open(const std::string& at, bool insecure, Page page,
                                                           const http::AccessOptions& access) {
  auto state = std::make_unique<State>(std::move(page));
  http::ListenOptions listen;
  listen.at = at;
  listen.option = "--metrics";
  listen.example_port = kExamplePort;
  listen.may_be_public = insecure;
  listen.risk = "anyone on the network could read the metrics there";
  listen.max_connections = kMaxConnections;
  auto loop = http::AcceptLoop::open(listen, *state);
  if (!loop) return loop.error();
  state->loop = std::move(*loop);
  state->set_access({.own_host = state->loop->host(),
                     .is_public = !state->loop->is_loopback(),
                     .clients = http::AccessRules::Clients::programs,
                     .options = access});
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

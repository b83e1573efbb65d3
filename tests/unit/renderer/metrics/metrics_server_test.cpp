// Test of the metrics page and its HTTP server: text format, limits, and misbehaving clients.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/metrics/metric_families.h"
#include "renderer/metrics/metrics_server.h"
#include "tests/unit/protocol/transport/raw_socket.h"

namespace fire3dv::metrics {
namespace {

using transport::test::RawSocket;

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(Exposition, WritesTheTextFormat) {
  Exposition page;
  page.family("a_total", "counter", "How many.");
  page.sample({}, uint64_t{18446744073709551615u});
  page.sample({{"x", "y"}, {"z", ""}}, 0.25);
  page.family("b", "gauge", "Odd numbers.");
  page.sample({}, std::numeric_limits<double>::quiet_NaN());
  page.sample({}, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(page.text(),
            "# HELP a_total How many.\n# TYPE a_total counter\na_total 18446744073709551615\n"
            "a_total{x=\"y\",z=\"\"} 0.25\n# HELP b Odd numbers.\n# TYPE b gauge\nb NaN\nb -Inf\n");
}

TEST(Exposition, ForeignTextStaysQuoted) {
  Exposition page;
  page.family("a", "gauge", "h");
  page.sample({{"name", "x\"} 1\nb 2\\"}}, uint64_t{3});
  EXPECT_EQ(page.text().substr(page.text().rfind("gauge\n") + 6), "a{name=\"x\\\"} 1\\nb 2\\\\\"} 3\n");
}

TEST(Histogram, CountsUpToEachBound) {
  Histogram histogram;
  for (const double seconds : {0.0, 0.0005, 0.0006, 0.3, 11.0}) histogram.add(seconds);
  histogram.add(-1);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.count(), 5u);
  EXPECT_EQ(histogram.count_up_to(0), 2u);
  EXPECT_EQ(histogram.count_up_to(1), 3u);
  EXPECT_EQ(histogram.count_up_to(8), 3u);
  EXPECT_EQ(histogram.count_up_to(9), 4u) << "0.3 takes less than 0.5";
  EXPECT_EQ(histogram.count_up_to(Histogram::kUpperBounds_s.size() - 1), 4u);
  EXPECT_DOUBLE_EQ(histogram.sum_s(), 11.3011);
  Exposition page;
  page.family("h", "histogram", "h");
  page.histogram({{"s", "1"}}, histogram);
  EXPECT_NE(page.text().find("h_bucket{s=\"1\",le=\"0.0005\"} 2\n"), std::string::npos) << page.text();
  EXPECT_NE(page.text().find("h_bucket{s=\"1\",le=\"+Inf\"} 5\nh_sum{s=\"1\"} 11.3011\nh_count{s=\"1\"} 5\n"),
            std::string::npos)
      << page.text();
}

TEST(PeerUse, UseIsListed) {
  PeerLimits limits;
  PeerUse peer{"tcp://[::1]:7346 \"arm\"\n\xff", "3", {}, {}};
  peer.used[static_cast<size_t>(Resource::names)] = 12;
  peer.refused[static_cast<size_t>(Resource::lights)] = 2;
  Exposition page;
  write_peer_use(page, limits, {peer, peer});
  const auto has = [&](const std::string& line) {
    EXPECT_NE(page.text().find(line + "\n"), std::string::npos) << line << " is not in\n" << page.text();
  };
  has("fire3dv_peers 2");
  has("fire3dv_peer_limit{resource=\"names\"} 1048576");
  const std::string name = "peer=\"tcp://[::1]:7346 \\\"arm\\\"??";
  has("fire3dv_peer_use{" + name + "\",stream=\"3\",resource=\"names\"} 12");
  has("fire3dv_peer_use{" + name + " #2\",stream=\"3\",resource=\"names\"} 12");
  has("fire3dv_peer_refusals_total{" + name + "\",resource=\"lights\"} 2");
}

TEST(PeerUse, ListsBoundedNumberOfPeers) {
  PeerLimits limits;
  std::vector<PeerUse> peers;
  for (uint64_t i = 0; i < 500; ++i) {
    peers.push_back({"peer " + std::to_string(i), "", {}, {}});
    peers.back().used[static_cast<size_t>(Resource::names)] = i;
  }
  peers[7].refused[static_cast<size_t>(Resource::edits)] = 1;
  Exposition page;
  write_peer_use(page, limits, peers);
  size_t listed = 0;
  for (size_t at = page.text().find("fire3dv_peer_use{"); at != std::string::npos;
       at = page.text().find("fire3dv_peer_use{", at + 1))
    ++listed;
  EXPECT_EQ(listed, kMaxListedPeers * kResourceCount);
  EXPECT_NE(page.text().find("fire3dv_peers 500\n"), std::string::npos);
  for (const char* peer : {"peer 7", "peer 499"})
    EXPECT_NE(page.text().find("peer=\"" + std::string(peer) + "\""), std::string::npos) << peer;
  EXPECT_EQ(page.text().find("peer=\"peer 8\""), std::string::npos) << "the least use is left out";
}

struct Server : testing::Test {
  std::unique_ptr<MetricsServer> server = open("127.0.0.1:0", false);
  std::string uri = "tcp://" + server->address();

  static std::unique_ptr<MetricsServer> open(const std::string& at, bool insecure) {
    auto opened = MetricsServer::open(at, insecure, [](Exposition& page) {
      page.family("answer", "gauge", "The answer.");
      page.sample({}, uint64_t{42});
    });
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return std::move(*opened);
  }
  static std::string all_of(RawSocket& socket) {
    std::string text;
    for (auto bytes = socket.receive(); !bytes.empty(); bytes = socket.receive())
      text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text;
  }
  std::string ask(std::string_view request) {
    RawSocket socket(uri, SOCK_STREAM);
    EXPECT_TRUE(socket.send(bytes_of(request)));
    return all_of(socket);
  }
  void expect_served() {
    const std::string text = ask("GET /metrics HTTP/1.0\r\n\r\n");
    EXPECT_TRUE(text.starts_with("HTTP/1.1 200 OK\r\n")) << text;
    EXPECT_NE(text.find("\nanswer 42\n"), std::string::npos) << text;
  }
};

TEST_F(Server, AnswersWithLengthThatIsRight) {
  const std::string text = ask("GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  const size_t body_at = text.find("\r\n\r\n") + 4;
  EXPECT_NE(text.find("Content-Length: " + std::to_string(text.size() - body_at) + "\r\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("Content-Type: text/plain; version=0.0.4; charset=utf-8\r\n"), std::string::npos);
}

TEST_F(Server, RequestMayComeByteByByte) {
  RawSocket socket(uri, SOCK_STREAM);
  for (const char c : std::string("GET /metrics HTTP/1.0\r\n\r\n")) {
    ASSERT_TRUE(socket.send(bytes_of(std::string_view(&c, 1))));
    ::usleep(1000);
  }
  EXPECT_TRUE(all_of(socket).starts_with("HTTP/1.1 200 OK\r\n"));
}

TEST_F(Server, OtherRequestsGetNoPage) {
  const std::pair<std::string, int> requests[] = {{"GET / HTTP/1.0\r\n\r\n", 404},
                                                  {"POST /metrics HTTP/1.0\r\n\r\nbody", 405},
                                                  {"F3DV\x01\x01\n\n", 400},
                                                  {std::string(3, '\0'), 400},
                                                  {"GET /metrics HTTP/9.9\r\n\r\n", 505},
                                                  {"GET /" + std::string(200'000, 'a'), 431}};
  for (const auto& [request, status] : requests) {
    const std::string text = ask(request);
    EXPECT_TRUE(text.starts_with("HTTP/1.1 " + std::to_string(status) + " ")) << status << ": " << text;
    EXPECT_EQ(text.find("answer"), std::string::npos);
  }
  const std::string page = ask("GET /metrics HTTP/1.0\r\n\r\n");
  for (const auto& [request, status] : requests)
    EXPECT_NE(page.find("requests_total{code=\"" + std::to_string(status) + "\"}"), std::string::npos);
  EXPECT_NE(page.find("requests_total{code=\"400\"} 2\n"), std::string::npos) << page;
}

TEST_F(Server, JudgesRequests) {
  const auto judge = [&](const std::string& line) {
    const std::string text = ask(line + "\r\n\r\n");
    return text.starts_with("HTTP/1.1 ") ? std::stoi(text.substr(9)) : 0;
  };
  EXPECT_EQ(judge("GET /metrics HTTP/1.1\r\nHost: localhost"), 200);
  EXPECT_EQ(judge("GET /metrics?collect=all HTTP/1.0"), 200);
  EXPECT_EQ(judge("GET /metrics HTTP/1.1\r\nHost: evil.example:9464"), 421);
  EXPECT_EQ(judge("GET /metrics HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil.example"), 403);
  for (const char* line : {"GET / HTTP/1.0", "GET /metrics/ HTTP/1.0", "GET /../metrics HTTP/1.0",
                           "GET http://localhost/metrics HTTP/1.0", "GET //metrics HTTP/1.0"})
    EXPECT_EQ(judge(line), 404) << line;
  for (const char* line : {"POST /metrics HTTP/1.0", "HEAD /metrics HTTP/1.0", "get /metrics HTTP/1.0",
                           "POST /metrics HTTP/1.0\r\nContent-Length: 18446744073709551615"})
    EXPECT_EQ(judge(line), 405) << line;
  for (const char* line : {"GET /metrics", "GET", "GET /metrics 1", " /metrics HTTP/1.0", "GET  HTTP/1.0",
                           "GET /met\trics HTTP/1.0", "GET /metrics\x80 HTTP/1.0",
                           "GET /metrics HTTP/1.0\r\nno field", "GET /metrics HTTP/1.0\nHost: a"})
    EXPECT_EQ(judge(line), 400) << line;
  for (const char* line : {"GET /metrics HTTP/2.0", "GET /metrics HTTP/1.", "GET /metrics HTTP/1.11",
                           "GET /metrics FTP/1.0", "GET /metrics x HTTP/1.0"})
    EXPECT_EQ(judge(line), 505) << line;
  EXPECT_EQ(judge("GET /metrics HTTP/1.0\r\nX: " + std::string(20'000, 'a')), 431);
}

TEST_F(Server, RandomBytesAndVisitorsWhoLeave) {
  for (uint32_t seed = 0; seed < 200; ++seed) {
    RawSocket socket(uri, SOCK_STREAM);
    socket.send(transport::test::random_bytes(seed * 7, seed));
    if (seed % 2 == 0) ::shutdown(socket.fd(), SHUT_WR);
    if (seed % 4 == 0) (void)all_of(socket);
  }
  expect_served();
}

TEST_F(Server, SilentConnectionIsClosed) {
  std::vector<RawSocket> silent;
  for (int i = 0; i < 200; ++i) silent.emplace_back(uri, SOCK_STREAM);
  silent.back().send(bytes_of("GET /metr"));
  expect_served();
  EXPECT_TRUE(silent.front().closed_by_peer());
  EXPECT_TRUE(all_of(silent.back()).starts_with("HTTP/1.1 408")) << "its time is over";
  const std::string page = ask("GET /metrics HTTP/1.0\r\n\r\n");
  EXPECT_EQ(page.find("sent_away_total{cause=\"full\"} 0\n"), std::string::npos) << page;
  EXPECT_EQ(page.find("sent_away_total{cause=\"slow\"} 0\n"), std::string::npos) << page;
}

TEST(ServerAddress, LoopbackUnlessOptionsAllowMore) {
  const auto error_of = [](const std::string& at) {
    auto opened = MetricsServer::open(at, false, [](Exposition&) {});
    EXPECT_FALSE(opened.ok()) << at;
    return opened.ok() ? std::string() : opened.error().message;
  };
  EXPECT_NE(error_of("0.0.0.0:0").find("--insecure"), std::string::npos);
  EXPECT_NE(error_of("[::]:0").find("--insecure"), std::string::npos);
  for (const char* wrong : {"", "9464", "localhost", "localhost:", "localhost:x", "localhost:99999", "::1:80",
                            "[::1]", "http://localhost:80", "a b:1"})
    EXPECT_NE(error_of(wrong).find("must be HOST:PORT"), std::string::npos) << error_of(wrong);
  const auto first = Server::open("localhost:0", false);
  EXPECT_NE(error_of(first->address()).find("port is in use"), std::string::npos)
      << error_of(first->address());
  EXPECT_NE(Server::open("0.0.0.0:0", true), nullptr);
  EXPECT_TRUE(Server::open("[::1]:0", false)->address().starts_with("[::1]:"));
}

}  // namespace
}  // namespace fire3dv::metrics

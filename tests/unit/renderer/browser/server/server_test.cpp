// Server of the live view against clients of plain sockets: page, headers, tokens, limits, images.
#include "renderer/browser/server/server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "base/unique_fd.h"

namespace fire3dv::serve {
namespace {

constexpr int kHangMs = 60'000;

std::unique_ptr<Server> open_server(const ServerLimits& limits = {},
                                    const transport::http::AccessOptions& access = {}) {
  ServerOptions options;
  options.access = access;
  options.at = "127.0.0.1:0";
  options.limits = limits;
  Result<std::unique_ptr<Server>> server = Server::open(options);
  EXPECT_TRUE(server.ok()) << server.error().message;
  return std::move(*server);
}

std::string host_of(const Server& server) {
  return server.address().substr(std::string("http://").size());
}

std::string token_of(const Server& server, Access access) {
  const std::string link = server.link(access);
  return link.substr(link.find('#') + 1);
}

class Client {
 public:
  // from: last number of the loopback address.
  explicit Client(const Server& server, uint32_t from = 1)
      : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const std::string host = host_of(server);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(std::stoi(host.substr(host.find(':') + 1))));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + from);
    EXPECT_EQ(::bind(fd_.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
    EXPECT_EQ(::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }

  void send(const std::string& bytes) { (void)::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  // Reads until the text has come; returns what has come, also at the end of the connection.
  std::string read_until(const std::string& text) {
    while (received_.find(text) == std::string::npos && read_some()) {
    }
    return std::exchange(received_, {});
  }
  std::string read_to_end() {
    while (read_some()) {
    }
    return std::exchange(received_, {});
  }
  bool read_some() {
    pollfd polled{fd_.get(), POLLIN, 0};
    if (::poll(&polled, 1, kHangMs) <= 0) {
      ADD_FAILURE() << "nothing came";
      return false;
    }
    char buffer[65536];
    const ssize_t got = ::recv(fd_.get(), buffer, sizeof buffer, 0);
    if (got > 0) received_.append(buffer, static_cast<size_t>(got));
    return got > 0;
  }

  // WebSocket frames of a client have a mask, here of zeros.
  void send_frame(uint8_t opcode, const std::string& payload) {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80 | payload.size());
    } else {
      frame += static_cast<char>(0x80 | 126);
      frame += static_cast<char>(payload.size() >> 8);
      frame += static_cast<char>(payload.size() & 255);
    }
    send(frame + std::string(4, '\0') + payload);
  }
  // Next frame: opcode and payload; opcode -1 at the end.
  std::pair<int, std::string> read_frame() {
    const auto need = [&](size_t bytes) {
      while (received_.size() < bytes)
        if (!read_some()) return false;
      return true;
    };
    const auto byte = [&](size_t at) { return static_cast<uint8_t>(received_[at]); };
    if (!need(2)) return {-1, {}};
    const int opcode = byte(0) & 15;
    uint64_t size = byte(1) & 127;
    size_t at = 2;
    if (size >= 126) {
      const size_t digits = size == 126 ? 2 : 8;
      if (!need(2 + digits)) return {-1, {}};
      for (size = 0; at < 2 + digits; ++at) size = size << 8 | byte(at);
    }
    if (!need(at + size)) return {-1, {}};
    std::string payload = received_.substr(at, size);
    received_.erase(0, at + size);
    return {opcode, payload};
  }
  // Close code of the server, 0 if the connection ends without one.
  int read_close() {
    for (;;) {
      const auto [opcode, payload] = read_frame();
      if (opcode == -1) return 0;
      if (opcode == 8 && payload.size() >= 2)
        return static_cast<uint8_t>(payload[0]) << 8 | static_cast<uint8_t>(payload[1]);
    }
  }

 private:
  UniqueFd fd_;
  std::string received_;
};

std::string upgrade_request(const std::string& host, const std::string& origin) {
  return "GET /socket HTTP/1.1\r\nHost: " + host + "\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
         "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
}

std::string hello(const std::string& token) {
  return R"({"type":"hello","token":")" + token + R"("})";
}

void upgrade(Client& client, const Server& server) {
  client.send(upgrade_request(host_of(server), server.address()));
  const std::string head = client.read_until("\r\n\r\n");
  EXPECT_TRUE(head.starts_with("HTTP/1.1 101")) << head;
  // The value for this key in RFC 6455, section 1.3.
  EXPECT_NE(head.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos) << head;
}

void join(Client& client, const Server& server, Access access = Access::control) {
  upgrade(client, server);
  client.send_frame(1, hello(token_of(server, access)));
}

std::vector<Event> wait_events(Server& server, size_t count) {
  std::vector<Event> events;
  for (int i = 0; i < kHangMs && events.size() < count; ++i) {
    for (Event& event : server.take_events()) events.push_back(std::move(event));
    if (events.size() < count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GE(events.size(), count);
  return events;
}

std::string get(const Server& server, const std::string& target, const std::string& host,
                const char* method = "GET") {
  Client client(server);
  client.send(std::string(method) + " " + target + " HTTP/1.1\r\nHost: " + host +
              "\r\nConnection: close\r\n\r\n");
  return client.read_to_end();
}

TEST(LiveServer, ServesPageUnderStrictPolicy) {
  const auto server = open_server();
  const std::string page = get(*server, "/", host_of(*server));
  EXPECT_TRUE(page.starts_with("HTTP/1.1 200")) << page;
  EXPECT_NE(page.find("<!doctype html>"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'; script-src 'self' 'sha256-"),
            std::string::npos);
  EXPECT_NE(page.find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_EQ(page.find("unsafe-inline"), std::string::npos);
  EXPECT_NE(page.find("nosniff"), std::string::npos);
  EXPECT_EQ(page.find(token_of(*server, Access::view)), std::string::npos);
  EXPECT_EQ(page.find("<script>"), page.rfind("<script>")) << "only one inline script has a hash";
  EXPECT_EQ(page.find("http://", page.find("\r\n\r\n")), std::string::npos) << "an address outside";
  EXPECT_NE(get(*server, "/?embed=1", host_of(*server)).find("frame-ancestors 'self' http://localhost:*"),
            std::string::npos);
}

TEST(LiveServer, ForeignOriginsAreRefused) {
  const auto server = open_server();
  const std::string host = host_of(*server);
  EXPECT_TRUE(get(*server, "/", "evil.example:80").starts_with("HTTP/1.1 421"));
  EXPECT_TRUE(get(*server, "/", "").starts_with("HTTP/1.1 421"));
  EXPECT_TRUE(get(*server, "/../etc/passwd", host).starts_with("HTTP/1.1 404"));
  EXPECT_TRUE(get(*server, "/", host, "POST").starts_with("HTTP/1.1 405"));
  EXPECT_TRUE(get(*server, "/socket", host).starts_with("HTTP/1.1 426"));
  EXPECT_TRUE(get(*server, "/" + std::string(40'000, 'a'), host).starts_with("HTTP/1.1 431"));
  for (const std::string& origin :
       {std::string(), std::string("null"), std::string("http://evil.example"), "https://" + host}) {
    Client client(*server);
    client.send(upgrade_request(host, origin));
    EXPECT_TRUE(client.read_until("\r\n\r\n").starts_with("HTTP/1.1 403")) << origin;
  }
  Client rebound(*server);
  rebound.send(upgrade_request("evil.example", "http://evil.example"));
  EXPECT_TRUE(rebound.read_until("\r\n\r\n").starts_with("HTTP/1.1 421"));
  Client garbage(*server);
  garbage.send(std::string("\x16\x03\x01\x02\x00\x01", 6) + "\r\n\r\n");
  EXPECT_TRUE(garbage.read_to_end().starts_with("HTTP/1.1 400"));
  EXPECT_TRUE(server->take_events().empty());
}

// A proxy at https://sim.example serves the page below /sim1/.
TEST(LiveServer, ProxiesAreServedBelowTheirPath) {
  std::mutex mutex;
  std::vector<std::string> lines;
  transport::http::AccessOptions access;
  access.sites.origins = {"https://sim.example"};
  access.log = [&](const std::string& line) {
    const std::scoped_lock lock(mutex);
    lines.push_back(line);
  };
  const auto server = open_server({}, access);
  const std::string own = host_of(*server);
  for (const std::string& host : {own, std::string("sim.example")}) {
    for (const char* target : {"/", "/sim1/", "//", "/sim1/index.html"})
      EXPECT_NE(get(*server, target, host).find("<!doctype html>"), std::string::npos) << target;
    for (const char* target : {"/main.js", "//main.js", "/sim1/main.js"})
      EXPECT_NE(get(*server, target, host).find("text/javascript"), std::string::npos) << target;
    Client client(*server);
    client.send(upgrade_request(host, "https://sim.example"));
    EXPECT_TRUE(client.read_until("\r\n\r\n").starts_with("HTTP/1.1 101")) << host;
  }
  EXPECT_NE(get(*server, "/sim1/?embed=1", own).find("https://127.0.0.1:* https://sim.example\r\n"),
            std::string::npos);
  EXPECT_TRUE(get(*server, "/sim1", own).starts_with("HTTP/1.1 404"));
  // Why a WebSocket was refused, for the page.
  const std::string refused = get(*server, "/socket?origin=https://evil.example", own);
  EXPECT_TRUE(refused.starts_with("HTTP/1.1 403")) << refused;
  EXPECT_NE(refused.find("start with --allow-origin https://evil.example"), std::string::npos) << refused;
  EXPECT_NE(
      get(*server, "/socket?origin=https://sim.example", own).find("must pass Upgrade and Connection on"),
      std::string::npos);
  EXPECT_TRUE(lines.empty()) << lines[0];
  // Attackers, each line logged once.
  for (int i = 0; i < 20; ++i) {
    for (const char* origin :
         {"https://evil.example", "http://sim.example", "https://sim.example.evil.example"}) {
      Client client(*server);
      client.send(upgrade_request(own, origin));
      EXPECT_TRUE(client.read_until("\r\n\r\n").starts_with("HTTP/1.1 403")) << origin;
    }
    EXPECT_TRUE(get(*server, "/", "evil" + std::to_string(i) + ".example").starts_with("HTTP/1.1 421"));
  }
  const std::scoped_lock lock(mutex);
  ASSERT_EQ(lines.size(), 4u) << "four different ones a minute";
  EXPECT_EQ(lines[0],
            "a request was refused: origin https://evil.example is not allowed; start with --allow-origin "
            "https://evil.example");
}

TEST(LiveServer, ATokenGivesAccess) {
  const auto server = open_server();
  for (const std::string& first :
       {hello("0123456789abcdef0123456789abcdef"), std::string(R"({"type":"show_all"})")}) {
    Client client(*server);
    upgrade(client, *server);
    client.send_frame(1, first);
    EXPECT_EQ(client.read_close(), 4401);
  }
  EXPECT_TRUE(server->take_events().empty());

  Client control(*server), viewer(*server);
  join(control, *server);
  std::vector<Event> events = wait_events(*server, 1);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, Event::Kind::joined);
  EXPECT_EQ(events[0].access, Access::control);
  const ViewerId first = events[0].viewer;
  join(viewer, *server, Access::view);
  events = wait_events(*server, 1);
  EXPECT_EQ(events[0].access, Access::view);
  EXPECT_NE(events[0].viewer, first);
  EXPECT_EQ(server->viewers(), 2u);

  // A viewer without control moves its camera only.
  viewer.send_frame(1, R"({"type":"show_all"})");
  viewer.send_frame(1, R"({"type":"orbit","yaw":1,"pitch":0})");
  events = wait_events(*server, 1);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].message.kind, ClientMessage::Kind::orbit);
  control.send_frame(1, R"({"type":"show_all"})");
  EXPECT_EQ(wait_events(*server, 1)[0].message.kind, ClientMessage::Kind::show_all);

  server->report_viewers_again();
  EXPECT_EQ(server->take_events().size(), 2u);
}

TEST(LiveServer, BadMessagesEndViewer) {
  const auto server = open_server();
  Client good(*server);
  join(good, *server);
  wait_events(*server, 1);
  const std::vector<std::tuple<uint8_t, std::string, int>> bad = {
      {1, "{", 1008}, {2, "binary", 1003}, {1, hello("again"), 1008}, {1, std::string(5000, ' '), 1009}};
  for (const auto& [opcode, payload, code] : bad) {
    Client client(*server);
    join(client, *server);
    wait_events(*server, 1);
    client.send_frame(opcode, payload);
    EXPECT_EQ(client.read_close(), code) << payload.substr(0, 20);
    EXPECT_EQ(wait_events(*server, 1)[0].kind, Event::Kind::left);
  }
  EXPECT_EQ(server->viewers(), 1u);
}

TEST(LiveServer, SendsTextsAndNewestImage) {
  const auto server = open_server();
  Client client(*server);
  join(client, *server);
  const ViewerId viewer = wait_events(*server, 1)[0].viewer;
  server->send(viewer, R"({"type":"welcome"})");
  EXPECT_EQ(client.read_frame(), std::pair(1, std::string(R"({"type":"welcome"})")));
  Image image;
  image.header.number = 1;
  image.header.width = 16;
  image.header.height = 8;
  image.rgba8.assign(size_t{4} * 16 * 8, 200);
  server->send_image(viewer, std::move(image));
  const auto [opcode, payload] = client.read_frame();
  EXPECT_EQ(opcode, 2);
  ASSERT_GT(payload.size(), kImageHeaderBytes + 2);
  EXPECT_EQ(payload[0], 1);
  EXPECT_EQ(payload.substr(kImageHeaderBytes, 2), "\xff\xd8");
  server->send(viewer + 100, "nobody");  // no effect
}

// A JPEG has 65,500 pixels a side at most: the viewer does not wait for an image that never comes.
TEST(LiveServer, EncodingFailureClosesConnection) {
  const auto server = open_server();
  Client client(*server);
  join(client, *server);
  const ViewerId viewer = wait_events(*server, 1)[0].viewer;
  Image image;
  image.header.width = 65535;
  image.header.height = 1;
  image.rgba8.assign(size_t{4} * 65535, 200);
  server->send_image(viewer, std::move(image));
  const std::vector<Event> events = wait_events(*server, 1);
  EXPECT_EQ(events[0].kind, Event::Kind::left);
  EXPECT_EQ(events[0].viewer, viewer);
}

TEST(LiveServer, ViewersConnectionsAndTimeAreLimited) {
  ServerLimits limits;
  limits.max_viewers = 1;
  limits.max_connections = 4;
  limits.handshake = std::chrono::seconds(1);
  const auto server = open_server(limits);
  Client viewer(*server);
  join(viewer, *server);
  wait_events(*server, 1);
  Client second(*server);
  join(second, *server);
  EXPECT_EQ(second.read_close(), 1013);
  // Silent connections make room for new ones, and end by themselves.
  std::vector<std::unique_ptr<Client>> silent;
  for (int i = 0; i < 20; ++i) silent.push_back(std::make_unique<Client>(*server));
  EXPECT_TRUE(get(*server, "/", host_of(*server)).starts_with("HTTP/1.1 200"));
  for (const auto& client : silent) EXPECT_EQ(client->read_to_end(), "");
  std::vector<std::unique_ptr<Client>> tokenless;  // as many as connections are allowed
  for (int i = 0; i < 8; ++i) {
    tokenless.push_back(std::make_unique<Client>(*server));
    upgrade(*tokenless.back(), *server);
  }
  EXPECT_TRUE(get(*server, "/", host_of(*server)).starts_with("HTTP/1.1 200"));
  Client nameless(*server);  // never sends its token
  upgrade(nameless, *server);
  EXPECT_EQ(nameless.read_close(), 0);
  EXPECT_EQ(server->viewers(), 1u);
}

// A flood of one address leaves a slow visitor of another one in, before the upgrade and before the token.
TEST(LiveServer, FloodOfOneAddressLeavesOthersIn) {
  ServerLimits limits;
  limits.max_connections = 4;
  const auto server = open_server(limits);
  Client visitor(*server, 9);
  std::vector<std::unique_ptr<Client>> flood;
  const auto more = [&] {
    for (int i = 0; i < 20; ++i) flood.push_back(std::make_unique<Client>(*server));
    EXPECT_TRUE(get(*server, "/", host_of(*server)).starts_with("HTTP/1.1 200"));  // all were accepted
  };
  more();
  upgrade(visitor, *server);
  more();
  visitor.send_frame(1, hello(token_of(*server, Access::view)));
  EXPECT_EQ(wait_events(*server, 1)[0].kind, Event::Kind::joined);
}

TEST(LiveServer, SlowReaderIsDisconnected) {
  ServerLimits limits;
  limits.max_queued_bytes = 1 << 20;
  limits.max_pending_messages = 8;
  const auto server = open_server(limits);
  Client slow(*server), fast(*server);
  join(fast, *server);
  wait_events(*server, 1);
  // 100 messages: at most 8 wait for the frame loop at any time, and none is lost.
  for (int i = 0; i < 100; ++i) fast.send_frame(1, R"({"type":"orbit","yaw":1,"pitch":0})");
  size_t taken = 0;
  for (int i = 0; i < kHangMs && taken < 100; ++i) {
    const size_t now = server->take_events().size();
    EXPECT_LE(now, 8u);
    taken += now;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(taken, 100u);

  join(slow, *server);
  const ViewerId viewer = wait_events(*server, 1)[0].viewer;
  for (int i = 0; i < 64; ++i) server->send(viewer, std::string(1 << 18, 'x'));
  const std::vector<Event> events = wait_events(*server, 1);
  EXPECT_EQ(events[0].kind, Event::Kind::left);
  EXPECT_EQ(events[0].viewer, viewer);
  EXPECT_EQ(server->viewers(), 1u);
}

// Silent connections, garbage, halves of requests, and WebSockets without a token, 100 of them at a time.
TEST(LiveServer, HostileConnectionsLeaveViewer) {
  const auto server = open_server();
  Client viewer(*server);
  join(viewer, *server);
  const ViewerId number = wait_events(*server, 1)[0].viewer;
  const std::string upgrading = upgrade_request(host_of(*server), server->address());
  std::deque<Client> hostile;
  for (int i = 1; i <= 10'000; ++i) {
    Client& client = hostile.emplace_back(*server);
    if (i % 4 == 1) client.send(std::string(100, '\x80'));
    if (i % 4 == 2) client.send(upgrading.substr(0, upgrading.size() / 2));
    if (i % 4 == 3) client.send(upgrading);
    if (hostile.size() > 100) hostile.pop_front();
    if (i % 100 != 0) continue;
    viewer.send_frame(1, R"({"type":"orbit","yaw":1,"pitch":0})");
    const std::vector<Event> events = wait_events(*server, 1);
    ASSERT_EQ(events.size(), 1u) << i;
    EXPECT_EQ(events[0].kind, Event::Kind::message);
    const std::string text = R"({"type":"notice","text":")" + std::to_string(i) + "\"}";
    server->send(number, text);
    ASSERT_EQ(viewer.read_frame(), std::pair(1, text));
  }
  EXPECT_EQ(server->viewers(), 1u);
  EXPECT_TRUE(get(*server, "/", host_of(*server)).starts_with("HTTP/1.1 200"));
}

TEST(LiveServer, AddressesBeyondLoopbackNeedProtection) {
  ServerOptions options;
  options.at = "0.0.0.0:0";
  const auto refused = Server::open(options);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("--tls-cert"), std::string::npos);
  options.insecure = true;
  EXPECT_TRUE(Server::open(options).ok());
  options.at = "8080";
  EXPECT_FALSE(Server::open(options).ok());
}

}  // namespace
}  // namespace fire3dv::serve

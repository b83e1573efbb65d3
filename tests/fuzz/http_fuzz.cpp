// Fuzz target of HTTP sessions: a client that sends any bytes and ends gets at most one answer for each of
// its requests, and the session ends.
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "protocol/transport/http/session.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

class Owner final : public transport::http::SessionOwner {
 public:
  Owner() : SessionOwner({1 << 10, 2}) {
    access = transport::http::AccessRules{
        .own_host = "localhost",
        .clients = transport::http::AccessRules::Clients::programs,
        .options = {.sites = {{"sim.example"}, {"https://sim.example"}},
                    .log = [](const std::string& line) { FIRE3DV_ASSERT(line.size() < 1000); }}};
  }

  void on_header(transport::http::Session& session) override {
    FIRE3DV_ASSERT(session.path().find('?') == std::string_view::npos);
    if (session.content_length().value_or(0) > 0) return session.read_body();
    session.answer({200, "text/plain", "page\n"});
  }
  void on_body(transport::http::Session& session) override {
    FIRE3DV_ASSERT(session.take_body().size() == *session.content_length());
    session.answer({200, "text/plain", "body\n"});
  }
  void check(std::string_view input) const {
    uint64_t answers = 0;
    for (const auto& [status, count] : answered) {
      FIRE3DV_ASSERT(status == 200 || (status >= 400 && status <= 505));
      answers += count;
    }
    FIRE3DV_ASSERT(answers <= 2 && open_connections() == 0 && body_bytes == 0);
    FIRE3DV_ASSERT(!answered.contains(200) || input.find("\r\n\r\n") != std::string_view::npos);
  }
};

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const std::string_view text :
       {"GET /metrics HTTP/1.1\r\nHost: localhost:9464\r\nAccept: text/plain;version=0.0.4\r\n\r\n",
        "GET /metrics?x=1 HTTP/1.0\n\n", "POST /metrics HTTP/1.1\r\nContent-Length: 4\r\n\r\nbody",
        "GET /a HTTP/1.1\r\n\r\nGET /b HTTP/1.1\r\n\r\n",
        "GET /a HTTP/1.1\r\nHost: sim.example:80\r\nOrigin: https://sim.example:443\r\n\r\n",
        "GET /a HTTP/1.1\r\nHost: [::1]:80\r\nOrigin: null\r\nUpgrade: websocket\r\n\r\n",
        "GET  HTTP/1.0\r\n\r\n", "GET /metrics HTTP/2.0\r\n\r\n"})
    inputs.emplace_back(text.begin(), text.end());
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  int ends[2];
  FIRE3DV_ASSERT(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) == 0);
  const ssize_t sent = size > 0 ? ::send(ends[0], data, size, MSG_NOSIGNAL) : 0;
  FIRE3DV_ASSERT(sent >= 0);
  ::shutdown(ends[0], SHUT_WR);
  fuzz::Owner owner;
  {
    boost::asio::io_context io;
    boost::asio::ip::tcp::socket socket(io);
    socket.assign(boost::asio::ip::tcp::v4(), ends[1]);
    owner.serve(std::move(socket));
    io.run();
  }
  owner.check({reinterpret_cast<const char*>(data), static_cast<size_t>(sent)});
  ::close(ends[0]);
  return 0;
}

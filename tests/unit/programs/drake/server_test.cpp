// Tests of the HTTP server for Drake's requests: answers from other threads, limits, and its end.
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cctype>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "programs/drake/http/server.h"

namespace fire3dv::drake {
namespace {

using boost::asio::ip::tcp;

// A server that answers with the body of the request, in capitals, from threads of its own.
class EchoServer {
 public:
  explicit EchoServer(const HttpLimits& limits = {}) {
    auto opened = HttpServer::open("127.0.0.1:0", false, limits,
                                   [this](HttpRequest&& request, HttpServer::Answer answer) {
                                     const std::lock_guard lock(mutex_);
                                     jobs_.emplace_back(std::move(request), std::move(answer));
                                     changed_.notify_one();
                                   });
    EXPECT_TRUE(opened) << opened.error().message;
    server_ = std::move(*opened);
    const std::string address = server_->address();
    port_ = static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
    serving_ = std::thread([this] { server_->run([] {}); });
    for (int i = 0; i < 3; ++i) workers_.emplace_back([this] { work(); });
  }
  ~EchoServer() {
    server_->stop();
    serving_.join();
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& worker : workers_) worker.join();
    jobs_.clear();
  }

  tcp::socket connect() {
    tcp::socket socket(client_);
    socket.connect({boost::asio::ip::address_v4::loopback(), port_});
    return socket;
  }
  // Sends text and returns all that the server sends until it closes.
  std::string exchange(const std::string& text) {
    tcp::socket socket = connect();
    boost::system::error_code error;
    boost::asio::write(socket, boost::asio::buffer(text), error);
    std::string answer;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
    return answer;
  }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
      if (stopping_) return;
      auto [request, answer] = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      for (char& c : request.body) c = static_cast<char>(std::toupper(c));
      answer({200, "text/plain", std::move(request.body)});
      answer = {};
      lock.lock();
    }
  }

  std::unique_ptr<HttpServer> server_;
  uint16_t port_ = 0;
  boost::asio::io_context client_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::pair<HttpRequest, HttpServer::Answer>> jobs_;
  bool stopping_ = false;
  std::thread serving_;
  std::vector<std::thread> workers_;
};

std::string request(const std::string& body, const std::string& more = "Connection: close\r\n") {
  return "POST /render HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=b\r\n" +
         more + "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

std::string body_of(const std::string& answer) {
  const size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

TEST(DrakeServer, AnswersFromOtherThreads) {
  EchoServer server;
  std::atomic<int> right = 0;
  std::vector<std::thread> clients;
  for (int c = 0; c < 8; ++c) {
    clients.emplace_back([&, c] {
      for (int i = 0; i < 20; ++i) {
        const std::string text =
            "request " + std::to_string(c) + "," + std::to_string(i) + std::string(20'000, '.');
        right += body_of(server.exchange(request(text))) == "REQUEST " + text.substr(8);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(right, 160);
}

TEST(DrakeServer, PipelinedRequestsAreRead) {
  EchoServer server;
  const std::string answers = server.exchange(request("one", "") + request("two", "") + request("three"));
  EXPECT_NE(answers.find("\r\n\r\nONEHTTP/1.1 200"), std::string::npos) << answers;
  EXPECT_NE(answers.find("\r\n\r\nTWOHTTP/1.1 200"), std::string::npos);
  EXPECT_TRUE(answers.ends_with("\r\n\r\nTHREE"));
}

TEST(DrakeServer, LimitsRequests) {
  HttpLimits limits;
  limits.max_body_bytes = 1 << 20;
  limits.max_total_bytes = 3 << 20;
  EchoServer server(limits);
  EXPECT_EQ(body_of(server.exchange(request(std::string(1 << 20, 'a')))), std::string(1 << 20, 'A'));
  EXPECT_TRUE(server.exchange(request(std::string((1 << 20) + 1, 'a'))).starts_with("HTTP/1.1 413"));
  const std::string chunked =
      "POST /render HTTP/1.1\r\nContent-Type: multipart/form-data\r\nTransfer-Encoding: chunked\r\n\r\n";
  EXPECT_TRUE(server.exchange(chunked + "fffffffffffffff\r\n").starts_with("HTTP/1.1 411"));
}

// Bodies that are only announced take no room, and end without progress.
TEST(DrakeServer, AnnouncedBodiesTakeNoRoom) {
  HttpLimits limits;
  limits.max_body_bytes = 1 << 20;
  limits.max_total_bytes = 3 << 20;
  limits.body_silence = std::chrono::seconds(1);
  EchoServer server(limits);
  std::vector<tcp::socket> slow;
  for (int i = 0; i < 10; ++i) {
    slow.push_back(server.connect());
    boost::asio::write(slow.back(), boost::asio::buffer(request(std::string(1 << 20, 'a')).substr(0, 500)));
  }
  for (int i = 0; i < 10; ++i) EXPECT_EQ(body_of(server.exchange(request("small"))), "SMALL");
  for (tcp::socket& socket : slow) {
    std::string answer;
    boost::system::error_code error;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 408")) << answer;
  }
}

// One client may have half of the room of bodies. What has arrived counts until its answer.
TEST(DrakeServer, ArrivedBodiesAreCharged) {
  HttpLimits limits;
  limits.max_body_bytes = 1 << 20;
  limits.max_total_bytes = 3 << 20;
  limits.body_silence = std::chrono::seconds(1);
  EchoServer server(limits);
  std::vector<tcp::socket> held;
  for (int i = 0; i < 3; ++i) {  // 3 x 600 KB are more than 1.5 MiB
    held.push_back(server.connect());
    const std::string part = request(std::string(1 << 20, 'a')).substr(0, 600'000);
    boost::system::error_code error;
    boost::asio::write(held.back(), boost::asio::buffer(part), error);
  }
  int refused = 0;
  for (tcp::socket& socket : held) {  // any of them, since all have one client
    std::string answer;
    boost::system::error_code error;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
    refused += answer.starts_with("HTTP/1.1 503") && answer.find("too many requests") != std::string::npos;
  }
  EXPECT_EQ(refused, 1);
  held.clear();
  std::string later;
  for (int i = 0; i < 1000 && !later.starts_with("HTTP/1.1 200"); ++i)
    later = server.exchange(request(std::string(1 << 20, 'b')));
  EXPECT_EQ(body_of(later), std::string(1 << 20, 'B'));
}

// Connections that stay within their bodies make room, too.
TEST(DrakeServer, StalledBodiesMakeRoom) {
  HttpLimits limits;
  limits.max_connections = 4;
  EchoServer server(limits);
  std::vector<tcp::socket> stalled;
  for (int i = 0; i < 4; ++i) {
    stalled.push_back(server.connect());
    boost::asio::write(stalled.back(), boost::asio::buffer(request("half of it").substr(0, 150)));
  }
  std::string answer;
  for (int i = 0; i < 1000 && !answer.starts_with("HTTP/1.1 200"); ++i) {
    answer = server.exchange(request("next"));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(body_of(answer), "NEXT");
}

TEST(DrakeServer, IdleConnectionsMakeRoom) {
  HttpLimits limits;
  limits.max_connections = 4;
  EchoServer server(limits);
  std::vector<tcp::socket> idle;
  for (int i = 0; i < 50; ++i) idle.push_back(server.connect());
  EXPECT_EQ(body_of(server.exchange(request("next"))), "NEXT");
}

TEST(DrakeServer, ErrorsFitDrakesLimit) {
  const HttpAnswer answer = http_error(400, std::string(100'000, '"') + "\xff\n");
  EXPECT_LT(answer.body.size(), 8192u);
  EXPECT_EQ(answer.status, 400u);
}

}  // namespace
}  // namespace fire3dv::drake

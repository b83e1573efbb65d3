// WebSocket of one viewer: checks its token, passes its messages to the hub within limits, and sends texts
// and images. Lives on the server's thread.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "protocol/transport/http/session.h"
#include "renderer/browser/server/hub.h"

namespace fire3dv::serve {

class ViewerSocket : public std::enable_shared_from_this<ViewerSocket> {
 public:
  ViewerSocket(std::unique_ptr<transport::http::Stream> stream, Hub& hub);
  ~ViewerSocket();
  ViewerSocket(const ViewerSocket&) = delete;
  ViewerSocket& operator=(const ViewerSocket&) = delete;

  // request: the upgrade request, whose headers have been checked.
  void start(const transport::http::Session::Request& request);
  void send(std::string&& text);
  void send(std::vector<uint8_t>&& binary);
  void resume();  // reading, after the frame loop took the messages
  bool has_joined() const { return access_ != Access::none; }
  const std::string& client() const { return stream_->client(); }
  std::chrono::steady_clock::time_point since() const { return stream_->since(); }
  void abort();

 private:
  using ErrorCode = boost::system::error_code;
  using CloseCode = boost::beast::websocket::close_code;
  struct Outgoing {
    bool is_text = false;
    std::string text;
    std::vector<uint8_t> binary;
    size_t bytes() const { return text.size() + binary.size(); }
  };

  void read();
  void on_read(ErrorCode error);
  bool take(std::string_view text);  // false: no further message is read now
  bool take_hello(const ClientMessage& message);
  void wait_for_rate();
  void wait_for_frame_loop();
  void queue(Outgoing&& outgoing);
  void write();
  void close(CloseCode code, std::string reason);

  Hub& hub_;
  const ViewerId number_;
  const std::unique_ptr<transport::http::Stream> stream_;
  boost::beast::websocket::stream<transport::http::Stream&> socket_;
  boost::asio::steady_timer timer_;  // for the token, then for the rate
  boost::beast::flat_buffer buffer_;
  Access access_ = Access::none;
  bool is_closing_ = false, is_writing_ = false, is_reading_ = false;
  std::deque<Outgoing> queue_;
  size_t queued_bytes_ = 0;
  // Token bucket of messages.
  double credit_ = 0;
  std::chrono::steady_clock::time_point credited_;
};

}  // namespace fire3dv::serve

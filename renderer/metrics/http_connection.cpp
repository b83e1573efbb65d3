#include "renderer/metrics/http_connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace fire3dv::metrics {
namespace {

constexpr size_t kMaxDrainedBytes = 64 << 10;

bool only_waits(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

const char* reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 431:
      return "Request Header Fields Too Large";
    case 505:
      return "HTTP Version Not Supported";
  }
  return "Bad Request";
}

bool is_printable(char c) {
  return c >= 0x20 && c <= 0x7e;
}

// Parses a request line without line end, for example "GET /metrics HTTP/1.1". Returns the response status.
int judge_line(std::string_view line) {
  if (!std::all_of(line.begin(), line.end(), is_printable)) return 400;
  const size_t first = line.find(' ');
  const size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == 0 || first == last) return 400;
  const std::string_view method = line.substr(0, first);
  std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (target.empty() || target.find(' ') != std::string_view::npos) return 400;
  if (!version.starts_with("HTTP/")) return 400;
  if (!version.starts_with("HTTP/1.") || version.size() != 8) return 505;
  if (method != "GET") return 405;
  target = target.substr(0, target.find('?'));  // scrapers may add query parameters; they are ignored
  return target == "/metrics" ? 200 : 404;
}

}  // namespace

std::optional<int> request_status(std::string_view request) {
  // Other protocols are rejected by their first byte; their data may never contain a line end.
  if (!request.empty() && !is_printable(request.front())) return 400;
  size_t end = request.find("\r\n\r\n");
  end = std::min(end, request.find("\n\n"));
  if (end == std::string_view::npos) {
    if (request.size() >= kMaxRequestBytes) return 431;
    return {};
  }
  std::string_view line = request.substr(0, request.find('\n'));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return judge_line(line);
}

std::string write_response(int status, std::string_view page) {
  const std::string reason = reason_of(status);
  const std::string plain =
      status == 404 ? "metrics are at /metrics\n" : std::to_string(status) + " " + reason + "\n";
  const std::string_view body = status == 200 ? page : std::string_view(plain);
  std::string text = "HTTP/1.0 " + std::to_string(status) + " " + reason + "\r\n";
  text += std::string("Content-Type: text/plain; ") + (status == 200 ? "version=0.0.4; " : "") +
          "charset=utf-8\r\n";
  if (status == 405) text += "Allow: GET\r\n";
  // Stream names are untrusted: nosniff prevents browsers from interpreting them as HTML.
  text += "X-Content-Type-Options: nosniff\r\nCache-Control: no-store\r\nConnection: close\r\n";
  text += "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n";
  return text.append(body);
}

short HttpConnection::wants() const {
  return state_ == State::sending ? POLLOUT : POLLIN;
}

void HttpConnection::go_on(const std::function<std::string(int status)>& answer) {
  if (state_ == State::receiving) receive(answer);
  if (state_ == State::sending && !over_) send();
  if (state_ == State::draining && !over_) drain();
}

void HttpConnection::receive(const std::function<std::string(int status)>& answer) {
  char buffer[2048];
  while (true) {
    const ssize_t got = ::recv(fd(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (got < 0 && only_waits(errno)) return;
    if (got <= 0) {
      over_ = true;
      return;
    }
    request_.append(buffer, static_cast<size_t>(got));
    const std::optional<int> status = request_status(request_);
    if (!status) continue;
    request_ = {};
    response_ = answer(*status);
    state_ = State::sending;
    return;
  }
}

void HttpConnection::send() {
  while (sent_ < response_.size()) {
    const ssize_t sent =
        ::send(fd(), response_.data() + sent_, response_.size() - sent_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && only_waits(errno)) return;
    if (sent < 0) {
      over_ = true;
      return;
    }
    sent_ += static_cast<size_t>(sent);
  }
  ::shutdown(fd(), SHUT_WR);
  state_ = State::draining;
}

// Drains unread input before close(): otherwise TCP resets the connection and discards the response.
void HttpConnection::drain() {
  char buffer[2048];
  while (true) {
    const ssize_t got = ::recv(fd(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (got < 0 && only_waits(errno)) return;
    if (got > 0) drained_ += static_cast<size_t>(got);
    if (got <= 0 || drained_ > kMaxDrainedBytes) {
      over_ = true;
      return;
    }
  }
}

}  // namespace fire3dv::metrics

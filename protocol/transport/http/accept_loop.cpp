#include "protocol/transport/http/accept_loop.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <map>
#include <string_view>
#include <utility>

#include "base/files.h"
#include "base/text.h"

namespace fire3dv::transport::http {
namespace {

using boost::asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptAgain{100};  // after descriptors ran out
constexpr size_t kMaxShownBytes = 80;                   // of an address

// Host and port follow the rules of link URIs.
Result<Uri> parse_address(const ListenOptions& options) {
  const std::string shown = printable_text(options.at, kMaxShownBytes);
  const std::string port = std::to_string(options.example_port);
  Result<Uri> uri = parse_uri("tcp://" + options.at);
  if (!uri)
    return Error{options.option + " '" + shown + "': must be HOST:PORT, such as 127.0.0.1:" + port +
                 " or [::1]:" + port};
  if (options.may_be_public) return uri;
  const Lookup lookup(*uri);
  while (!lookup.done()) ::poll(nullptr, 0, 1);
  for (const Address& address : lookup.addresses()) {
    if (!address.is_loopback())
      return Error{options.option + " " + shown + ": " + options.risk + "; " +
                   (options.remedy.empty() ? "" : options.remedy + ", ") + "use " +
                   (address.family() == AF_INET6 ? "[::1]" : "127.0.0.1") +
                   ", or --insecure if that is wanted"};
  }
  return uri;
}

}  // namespace

Result<std::unique_ptr<AcceptLoop>> AcceptLoop::open(const ListenOptions& options, ConnectionOwner& owner) {
  Result<Uri> uri = parse_address(options);
  if (!uri) return uri.error();
  Result<BoundSocket> bound = bind_listener(*uri, SOCK_STREAM, options.may_be_public);
  if (!bound) return Error{options.option + ": " + bound.error().message};
  std::unique_ptr<AcceptLoop> loop(new AcceptLoop(owner, options.max_connections));
  loop->host_ = uri->host;
  loop->is_loopback_ = bound->address.is_loopback();
  uri->port = bound->address.port();
  loop->address_ = uri_text(*uri).substr(std::string("tcp://").size());
  const int fd = ::fcntl(bound->fd.get(), F_DUPFD_CLOEXEC, 0);  // Asio owns its own descriptor
  if (fd < 0) return Error{options.option + " " + loop->address_ + ": " + system_reason(errno)};
  boost::system::error_code error;
  loop->acceptor_.assign(bound->address.family() == AF_INET6 ? tcp::v6() : tcp::v4(), fd, error);
  if (error) return Error{options.option + " " + loop->address_ + ": " + error.message()};
  return loop;
}

std::string client_of(const tcp::socket& socket) {
  boost::system::error_code error;
  const boost::asio::ip::address address = socket.remote_endpoint(error).address();
  if (error) return "";
  if (!address.is_v6() || address.to_v6().is_v4_mapped()) return address.to_string();
  boost::asio::ip::address_v6::bytes_type bytes = address.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), uint8_t{0});
  return boost::asio::ip::address_v6(bytes).to_string();
}

const OpenConnection* choose_evicted(const std::vector<OpenConnection>& open, const std::string& newcomer) {
  using Use = OpenConnection::Use;
  std::map<std::string_view, size_t> count_of_client;
  for (const OpenConnection& each : open) ++count_of_client[each.client];
  const size_t newcomers = count_of_client[newcomer] + 1;
  const OpenConnection* chosen = nullptr;
  size_t most = 0;
  for (const OpenConnection& each : open) {
    const size_t count = count_of_client[each.client];
    if (each.use == Use::kept || (each.use == Use::receiving && count <= newcomers)) continue;
    if (count < most || (chosen && count == most && each.since >= chosen->since)) continue;
    chosen = &each;
    most = count;
  }
  return chosen;
}

void AcceptLoop::run() {
  accept();
  while (!io_.stopped()) {
    try {
      io_.run();
    } catch (const std::exception&) {  // memory or TLS: a connection is lost; its client asks again
    }
  }
}

void AcceptLoop::accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == boost::asio::error::operation_aborted) return;
    if (!error) {
      accept();
      return take(std::move(socket));
    }
    accept_again_.expires_after(kAcceptAgain);
    accept_again_.async_wait([this](boost::system::error_code stopped) {
      if (!stopped) accept();
    });
  });
}

void AcceptLoop::take(tcp::socket&& socket) {
  if (owner_.open_connections() >= max_connections_) {
    const std::vector<OpenConnection> open = owner_.list_connections();
    if (const OpenConnection* const evicted = choose_evicted(open, client_of(socket))) evicted->close();
  }
  if (owner_.open_connections() >= max_connections_) return owner_.refuse(socket);
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  owner_.serve(std::move(socket));
}

}  // namespace fire3dv::transport::http

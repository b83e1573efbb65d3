#include "tools/bench/dtls_loopback.h"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace fire3dv::bench {
namespace {

constexpr size_t kKeyBytes = 32, kCookieBytes = 32;
constexpr int kMostHandshakeSteps = 10'000;

unsigned give_key(SSL*, const char*, char* identity, unsigned identity_bytes, unsigned char* key, unsigned) {
  if (identity != nullptr) std::snprintf(identity, identity_bytes, "fire3dv");
  std::fill_n(key, kKeyBytes, static_cast<unsigned char>(0x11));
  return kKeyBytes;
}
unsigned give_key_to_server(SSL* ssl, const char*, unsigned char* key, unsigned key_bytes) {
  return give_key(ssl, nullptr, nullptr, 0, key, key_bytes);
}

int make_cookie(SSL*, unsigned char* cookie, unsigned* bytes) {
  std::fill_n(cookie, kCookieBytes, static_cast<unsigned char>(0x22));
  *bytes = kCookieBytes;
  return 1;
}
int check_cookie(SSL*, const unsigned char*, unsigned bytes) {
  return bytes == kCookieBytes;
}

Error openssl_error(const std::string& what) {
  const char* reason = ::ERR_reason_error_string(::ERR_get_error());
  return Error{what + ": " + (reason != nullptr ? reason : "no reason given by OpenSSL")};
}

}  // namespace

Result<LoopbackSocket> bind_loopback() {
  LoopbackSocket socket{transport::UniqueFd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0))};
  socket.address.sin_family = AF_INET;
  socket.address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const address = reinterpret_cast<sockaddr*>(&socket.address);
  socklen_t length = sizeof socket.address;
  if (::bind(socket.fd.get(), address, length) != 0 || ::getsockname(socket.fd.get(), address, &length) != 0)
    return Error{std::string("a UDP socket on loopback: ") + std::strerror(errno)};
  return socket;
}

Result<SocketPair> make_socket_pair() {
  auto from = bind_loopback(), to = bind_loopback();
  if (!from) return from.error();
  if (!to) return to.error();
  const auto connect = [](const LoopbackSocket& socket, const LoopbackSocket& peer) {
    return ::connect(socket.fd.get(), reinterpret_cast<const sockaddr*>(&peer.address),
                     sizeof peer.address) == 0;
  };
  if (!connect(*from, *to) || !connect(*to, *from))
    return Error{std::string("UDP sockets on loopback: ") + std::strerror(errno)};
  return SocketPair{std::move(from->fd), std::move(to->fd)};
}

void HandshakeCount::add(bool is_client, size_t datagram_bytes) {
  ++datagrams;
  bytes += datagram_bytes;
  if (is_client && !last_was_client) ++round_trips;
  last_was_client = is_client;
}

long DtlsLoopback::on_write(BIO* bio, int operation, const char*, size_t, int, long, int result,
                            size_t* processed) {
  if (operation == (BIO_CB_WRITE | BIO_CB_RETURN) && result > 0) {
    const Side& side = *reinterpret_cast<const Side*>(::BIO_get_callback_arg(bio));
    if (side.count != nullptr) side.count->add(side.is_client, *processed);
  }
  return result;
}

DtlsLoopback::Connection DtlsLoopback::make_end(const Context& context, int fd, int peer_fd, bool is_client) {
  Connection end(::SSL_new(context.get()), ::SSL_free);
  BIO* const bio = ::BIO_new_dgram(fd, BIO_NOCLOSE);
  if (!end || bio == nullptr) return Connection(nullptr, ::SSL_free);
  sockaddr_in peer{};
  socklen_t length = sizeof peer;
  ::getsockname(peer_fd, reinterpret_cast<sockaddr*>(&peer), &length);
  BIO_ctrl_set_connected(bio, &peer);
  Side& side = sides_[is_client];
  side = {&count_, is_client};
  ::BIO_set_callback_ex(bio, on_write);
  ::BIO_set_callback_arg(bio, reinterpret_cast<char*>(&side));
  ::SSL_set_bio(end.get(), bio, bio);
  ::SSL_set_options(end.get(),
                    SSL_OP_NO_QUERY_MTU | SSL_OP_NO_TICKET | (is_client ? 0 : SSL_OP_COOKIE_EXCHANGE));
  ::SSL_set_mtu(end.get(), 1200);
  is_client ? ::SSL_set_connect_state(end.get()) : ::SSL_set_accept_state(end.get());
  return end;
}

Result<std::unique_ptr<DtlsLoopback>> DtlsLoopback::open(const char* cipher) {
  std::unique_ptr<DtlsLoopback> loopback(new DtlsLoopback);
  if (auto connected = loopback->connect(cipher); !connected) return connected.error();
  return loopback;
}

Result<void> DtlsLoopback::connect(const char* cipher) {
  auto sockets = make_socket_pair();
  if (!sockets) return sockets.error();
  sockets_ = std::move(*sockets);
  client_context_.reset(::SSL_CTX_new(::DTLS_client_method()));
  server_context_.reset(::SSL_CTX_new(::DTLS_server_method()));
  if (!client_context_ || !server_context_) return openssl_error("DTLS cannot be set up");
  for (SSL_CTX* const context : {client_context_.get(), server_context_.get()}) {
    ::SSL_CTX_set_min_proto_version(context, DTLS1_2_VERSION);
    if (::SSL_CTX_set_cipher_list(context, cipher) != 1) return openssl_error(cipher);
  }
  ::SSL_CTX_set_psk_client_callback(client_context_.get(), give_key);
  ::SSL_CTX_set_psk_server_callback(server_context_.get(), give_key_to_server);
  ::SSL_CTX_set_cookie_generate_cb(server_context_.get(), make_cookie);
  ::SSL_CTX_set_cookie_verify_cb(server_context_.get(), check_cookie);
  client_ = make_end(client_context_, sockets_.from.get(), sockets_.to.get(), true);
  server_ = make_end(server_context_, sockets_.to.get(), sockets_.from.get(), false);
  if (!client_ || !server_) return openssl_error("DTLS cannot be set up");
  for (int step = 0; step < kMostHandshakeSteps; ++step) {
    SSL* const end = step % 2 == 0 ? client_.get() : server_.get();
    const int done = ::SSL_do_handshake(end);
    if (done != 1 && ::SSL_get_error(end, done) != SSL_ERROR_WANT_READ) return openssl_error(cipher);
    if (!::SSL_is_init_finished(client_.get()) || !::SSL_is_init_finished(server_.get())) continue;
    sides_[0].count = sides_[1].count = nullptr;
    return {};
  }
  return Error{std::string(cipher) + ": the handshake does not end"};
}

bool DtlsLoopback::send(std::span<const std::byte> payload) {
  return ::SSL_write(client_.get(), payload.data(), static_cast<int>(payload.size())) ==
         static_cast<int>(payload.size());
}

bool DtlsLoopback::receive(std::span<const std::byte> expected) {
  std::vector<std::byte> opened(size_t{16} << 10);
  const int got = ::SSL_read(server_.get(), opened.data(), static_cast<int>(opened.size()));
  return got >= 0 && std::equal(expected.begin(), expected.end(), opened.begin(), opened.begin() + got);
}

}  // namespace fire3dv::bench

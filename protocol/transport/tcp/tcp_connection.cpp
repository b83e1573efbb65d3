#include "protocol/transport/tcp/tcp_connection.h"

#include <arpa/inet.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <climits>

#include "protocol/transport/core/secret.h"

namespace fire3dv::transport::tcp {
namespace {

TlsContext new_context(const SSL_METHOD* method) {
  TlsContext context(::SSL_CTX_new(method), ::SSL_CTX_free);
  if (!context) return context;
  ::SSL_CTX_set_min_proto_version(context.get(), TLS1_3_VERSION);
  ::SSL_CTX_set_num_tickets(context.get(), 0);  // sessions are long and are never resumed
  ::SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_RELEASE_BUFFERS);
  return context;
}

Error openssl_error(const std::string& uri, const std::string& what) {
  const char* reason = ::ERR_reason_error_string(::ERR_peek_last_error());
  ::ERR_clear_error();
  return Error{uri + ": " + what + (reason != nullptr ? std::string(" (") + reason + ")" : std::string())};
}

// Prevents a pass phrase prompt on the terminal: the file's mode protects the key.
int no_pass_phrase(char*, int, int, void*) {
  return 0;
}

Result<void> use_identity(const TlsContext& context, const std::string& uri, const std::string& certificate,
                          const std::string& key) {
  if (key.empty()) return Error{uri + ": the certificate's key is missing; name its file"};
  if (::SSL_CTX_use_certificate_chain_file(context.get(), certificate.c_str()) != 1)
    return openssl_error(uri,
                         "the certificate '" + certificate + "' cannot be read; it has to be a PEM file");
  const Result<Secret> secret = read_secret_file(key);
  if (!secret) return Error{uri + ": " + secret.error().message};
  const std::unique_ptr<BIO, decltype(&::BIO_free)> memory(
      ::BIO_new_mem_buf(secret->bytes().data(), static_cast<int>(secret->bytes().size())), ::BIO_free);
  const std::unique_ptr<EVP_PKEY, decltype(&::EVP_PKEY_free)> parsed(
      ::PEM_read_bio_PrivateKey(memory.get(), nullptr, no_pass_phrase, nullptr), ::EVP_PKEY_free);
  if (!parsed)
    return openssl_error(uri,
                         "the key '" + key + "' cannot be read; it has to be PEM, without a pass phrase");
  if (::SSL_CTX_use_PrivateKey(context.get(), parsed.get()) != 1 ||
      ::SSL_CTX_check_private_key(context.get()) != 1)
    return openssl_error(uri,
                         "the key '" + key + "' does not belong to the certificate '" + certificate + "'");
  return {};
}

std::string last_reason() {
  const unsigned long code = ::ERR_peek_last_error();
  const char* reason = ::ERR_reason_error_string(code);
  ::ERR_clear_error();
  return reason != nullptr ? reason : "no reason given";
}

}  // namespace

Result<TlsContext> make_server_context(const std::string& uri, const TlsListenerOptions& options) {
  if (options.certificate_file.empty())
    return Error{uri + ": a tls:// listener needs a certificate and its key; name both files"};
  TlsContext context = new_context(::TLS_server_method());
  if (!context) return openssl_error(uri, "TLS cannot be set up");
  if (auto used = use_identity(context, uri, options.certificate_file, options.key_file); !used)
    return used.error();
  if (!options.client_ca_file.empty()) {
    if (::SSL_CTX_load_verify_file(context.get(), options.client_ca_file.c_str()) != 1)
      return openssl_error(uri, "the certificates '" + options.client_ca_file +
                                    "' that clients have to be signed by cannot be read");
    ::SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  }
  return context;
}

Result<TlsContext> make_client_context(const std::string& uri, const TlsPublisherOptions& options) {
  TlsContext context = new_context(::TLS_client_method());
  if (!context) return openssl_error(uri, "TLS cannot be set up");
  if (!options.certificate_file.empty()) {
    if (auto used = use_identity(context, uri, options.certificate_file, options.key_file); !used)
      return used.error();
  }
  if (options.ca_file.empty()) {
    if (::SSL_CTX_set_default_verify_paths(context.get()) != 1)
      return openssl_error(uri, "the system's certificates cannot be read; name those to trust");
  } else if (::SSL_CTX_load_verify_file(context.get(), options.ca_file.c_str()) != 1) {
    return openssl_error(uri, "the certificates '" + options.ca_file + "' to trust cannot be read");
  }
  ::SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  return context;
}

TlsSession::TlsSession(ssl_st* ssl) : ssl_(ssl) {
  ::SSL_set_bio(ssl_, ::BIO_new(::BIO_s_mem()), ::BIO_new(::BIO_s_mem()));
}

TlsSession::~TlsSession() {
  ::SSL_free(ssl_);
}

std::unique_ptr<TlsSession> TlsSession::client(const TlsContext& context, const std::string& host) {
  ssl_st* ssl = ::SSL_new(context.get());
  if (ssl == nullptr) return nullptr;
  std::unique_ptr<TlsSession> session(new TlsSession(ssl));
  in6_addr address;
  const bool is_address =
      ::inet_pton(AF_INET, host.c_str(), &address) == 1 || ::inet_pton(AF_INET6, host.c_str(), &address) == 1;
  X509_VERIFY_PARAM* expected = ::SSL_get0_param(ssl);
  if (is_address) {
    if (::X509_VERIFY_PARAM_set1_ip_asc(expected, host.c_str()) != 1) return nullptr;
  } else {
    ::X509_VERIFY_PARAM_set_hostflags(expected, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
    if (::X509_VERIFY_PARAM_set1_host(expected, host.c_str(), host.size()) != 1 ||
        ::SSL_set_tlsext_host_name(ssl, host.c_str()) != 1)
      return nullptr;
  }
  ::SSL_set_connect_state(ssl);
  return session;
}

std::unique_ptr<TlsSession> TlsSession::server(const TlsContext& context) {
  ssl_st* ssl = ::SSL_new(context.get());
  if (ssl == nullptr) return nullptr;
  std::unique_ptr<TlsSession> session(new TlsSession(ssl));
  ::SSL_set_accept_state(ssl);
  return session;
}

bool TlsSession::established() const {
  return ::SSL_is_init_finished(ssl_) == 1;
}

void TlsSession::drain(std::vector<std::byte>& to) {
  BIO* out = ::SSL_get_wbio(ssl_);
  for (size_t waiting = ::BIO_ctrl_pending(out); waiting != 0; waiting = ::BIO_ctrl_pending(out)) {
    const size_t at = to.size();
    to.resize(at + waiting);
    const int got = ::BIO_read(out, to.data() + at, static_cast<int>(std::min<size_t>(waiting, INT_MAX)));
    to.resize(at + static_cast<size_t>(std::max(got, 0)));
    if (got <= 0) return;
  }
}

// Prefers the result of the certificate verification, which is more specific than the resulting alert.
bool TlsSession::fail() {
  const long verified = ::SSL_get_verify_result(ssl_);
  problem_ = "TLS failed: " + last_reason();
  if (verified != X509_V_OK)
    problem_ =
        std::string("the peer's certificate is not trusted: ") + ::X509_verify_cert_error_string(verified);
  ::ERR_clear_error();
  return false;
}

bool TlsSession::handshake(std::vector<std::byte>& to_send) {
  ::ERR_clear_error();
  const int outcome = ::SSL_do_handshake(ssl_);
  const int error = outcome == 1 ? SSL_ERROR_NONE : ::SSL_get_error(ssl_, outcome);
  drain(to_send);
  return error == SSL_ERROR_NONE || error == SSL_ERROR_WANT_READ || fail();
}

bool TlsSession::receive(std::span<const std::byte> sealed, std::vector<std::byte>& plain,
                         std::vector<std::byte>& to_send) {
  if (::BIO_write(::SSL_get_rbio(ssl_), sealed.data(), static_cast<int>(sealed.size())) !=
      static_cast<int>(sealed.size()))
    return fail();
  if (!established()) {
    if (!handshake(to_send)) return false;
    if (!established()) return true;
  }
  ::ERR_clear_error();
  while (true) {
    constexpr size_t kRecordBytes = 16 << 10;
    const size_t at = plain.size();
    plain.resize(at + kRecordBytes);
    size_t got = 0;
    const int outcome = ::SSL_read_ex(ssl_, plain.data() + at, kRecordBytes, &got);
    plain.resize(at + got);
    if (outcome == 1) continue;
    const int error = ::SSL_get_error(ssl_, outcome);
    drain(to_send);
    if (error == SSL_ERROR_WANT_READ) return true;
    if (error != SSL_ERROR_ZERO_RETURN) return fail();
    return false;  // closed in order
  }
}

bool TlsSession::seal(std::span<const std::byte> plain, std::vector<std::byte>& to) {
  ::ERR_clear_error();
  while (!plain.empty()) {
    size_t written = 0;
    if (::SSL_write_ex(ssl_, plain.data(), plain.size(), &written) != 1) return fail();
    plain = plain.subspan(written);
  }
  drain(to);
  return true;
}

}  // namespace fire3dv::transport::tcp

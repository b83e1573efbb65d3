// Certificates and keys of tls:// links.
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include "protocol/transport/core/secret.h"
#include "protocol/transport/tcp/tls_session.h"

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

}  // namespace fire3dv::transport::tcp

#include "protocol/transport/udp/udp_dtls.h"

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/ssl.h>
#include <string.h>
#include <sys/time.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <string_view>
#include <utility>

#include "base/clock.h"
#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

// One version and one suite: no downgrade is possible. To be DTLS1_3_VERSION when OpenSSL supports it.
constexpr int kLeastVersion = DTLS1_2_VERSION, kNewestVersion = DTLS1_2_VERSION;
constexpr const char* kSuite = "ECDHE-PSK-CHACHA20-POLY1305";
constexpr const char* kGroup = "X25519";

// The identity consists of protocol, version, mode and a hash of the key.
constexpr std::string_view kProtocol = "FIRE-3DV udp ";
constexpr std::string_view kVersionAndMode = "FIRE-3DV udp 1 sealed ";
static_assert(kTransportVersion == 1);

// OpenSSL treats a timeout that is less than 15 ms away as expired.
constexpr unsigned kFirstRepeatUs = 50'000, kLongestRepeatUs = 1'000'000;

// Derives an independent key for each use (HMAC-SHA256).
PreSharedKey::Key derive(const Secret& secret, std::string_view use) {
  PreSharedKey::Key key{};
  unsigned bytes = 0;
  const auto* const from = reinterpret_cast<const unsigned char*>(secret.bytes().data());
  const auto* const text = reinterpret_cast<const unsigned char*>(use.data());
  ::HMAC(::EVP_sha256(), from, static_cast<int>(secret.bytes().size()), text, use.size(), key.data(), &bytes);
  FIRE3DV_ASSERT(bytes == key.size());
  return key;
}

std::string make_identity(const Secret& secret) {
  std::string identity(kVersionAndMode);
  const PreSharedKey::Key hash = derive(secret, "FIRE-3DV udp 1 key name");
  for (size_t i = 0; i < 8; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    identity += kDigits[hash[i] >> 4];
    identity += kDigits[hash[i] & 15];
  }
  return identity;
}

unsigned next_repeat_us(SSL*, unsigned us) {
  return us == 0 ? kFirstRepeatUs : std::min(2 * us, kLongestRepeatUs);
}

}  // namespace

// OpenSSL callbacks. They must not throw.
struct DtlsCallbacks {
  static Dtls& self(SSL* ssl) { return *static_cast<Dtls*>(SSL_get_app_data(ssl)); }

  static unsigned give_publishers_key(SSL* ssl, const char*, char* identity, unsigned identity_room,
                                      unsigned char* key, unsigned key_room) {
    const PreSharedKey& known = *self(ssl).key_;
    if (known.identity().size() >= identity_room || known.key().size() > key_room) return 0;
    std::memcpy(identity, known.identity().c_str(), known.identity().size() + 1);
    std::copy(known.key().begin(), known.key().end(), key);
    return static_cast<unsigned>(known.key().size());
  }

  static unsigned give_listeners_key(SSL* ssl, const char* identity, unsigned char* key, unsigned room) {
    Dtls& dtls = self(ssl);
    const std::string_view received = identity != nullptr ? identity : "";
    if (received != dtls.key_->identity() || dtls.key_->key().size() > room) {
      const bool is_other_version = received.starts_with(kProtocol) && !received.starts_with(kVersionAndMode);
      dtls.refusal_ = is_other_version ? Refusal::version_mismatch : Refusal::bad_key;
      return 0;
    }
    std::copy(dtls.key_->key().begin(), dtls.key_->key().end(), key);
    return static_cast<unsigned>(dtls.key_->key().size());
  }

  static int make_cookie(SSL* ssl, unsigned char* cookie, unsigned* bytes) {
    const Dtls& dtls = self(ssl);
    if (dtls.cookies_ == nullptr) return 0;
    try {
      put_le<uint64_t>(reinterpret_cast<std::byte*>(cookie), dtls.cookies_->make());
    } catch (const std::exception&) {
      return 0;
    }
    *bytes = sizeof(uint64_t);
    return 1;
  }

  static int check_cookie(SSL* ssl, const unsigned char* cookie, unsigned bytes) {
    const Dtls& dtls = self(ssl);
    if (dtls.has_valid_cookie_) return 1;  // OpenSSL checks twice: in DTLSv1_listen() and in the handshake
    if (dtls.cookies_ == nullptr || bytes != sizeof(uint64_t)) return 0;
    try {
      return dtls.cookies_->check(get_le<uint64_t>(reinterpret_cast<const std::byte*>(cookie))) ? 1 : 0;
    } catch (const std::exception&) {
      return 0;
    }
  }
};

// --- the key

PreSharedKey::~PreSharedKey() {
  ::explicit_bzero(key_.data(), key_.size());
}

Result<std::shared_ptr<const PreSharedKey>> PreSharedKey::create(const Key& key,
                                                                 const std::string& identity) {
  const std::shared_ptr<PreSharedKey> created(new PreSharedKey(key, identity));
  created->context_.reset(::SSL_CTX_new(::DTLS_method()), ::SSL_CTX_free);
  SSL_CTX* const context = created->context_.get();
  if (context == nullptr || ::SSL_CTX_set_min_proto_version(context, kLeastVersion) != 1 ||
      ::SSL_CTX_set_max_proto_version(context, kNewestVersion) != 1 ||
      ::SSL_CTX_set_cipher_list(context, kSuite) != 1 || SSL_CTX_set1_groups_list(context, kGroup) != 1) {
    ::ERR_clear_error();
    return Error{"this system's OpenSSL has no DTLS 1.2 with " + std::string(kSuite) + " and " + kGroup +
                 "; allow them in its configuration"};
  }
  ::SSL_CTX_set_options(context, SSL_OP_NO_QUERY_MTU | SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION |
                                     SSL_OP_NO_COMPRESSION | SSL_OP_COOKIE_EXCHANGE);
  ::SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  ::SSL_CTX_set_psk_client_callback(context, DtlsCallbacks::give_publishers_key);
  ::SSL_CTX_set_psk_server_callback(context, DtlsCallbacks::give_listeners_key);
  ::SSL_CTX_set_cookie_generate_cb(context, DtlsCallbacks::make_cookie);
  ::SSL_CTX_set_cookie_verify_cb(context, DtlsCallbacks::check_cookie);
  return std::shared_ptr<const PreSharedKey>(created);
}

Result<std::shared_ptr<const PreSharedKey>> PreSharedKey::from_secret(const Secret& secret) {
  Key key = derive(secret, "FIRE-3DV udp 1 DTLS key");
  auto created = create(key, make_identity(secret));
  ::explicit_bzero(key.data(), key.size());
  return created;
}

Result<std::shared_ptr<const PreSharedKey>> PreSharedKey::from_file(const std::string& path, const Uri& uri) {
  if (path.empty()) return std::shared_ptr<const PreSharedKey>();
  const Result<Secret> secret = read_key_file(path);
  if (!secret) return Error{uri_text(uri) + ": " + secret.error().message};
  return from_secret(*secret);
}

std::unique_ptr<Dtls> PreSharedKey::connect() const {
  auto dtls = listen();
  if (dtls) ::SSL_set_connect_state(dtls->ssl_);
  return dtls;
}

std::unique_ptr<Dtls> PreSharedKey::listen() const {
  std::unique_ptr<Dtls> dtls(new Dtls(shared_from_this()));
  dtls->ssl_ = ::SSL_new(context_.get());
  BIO* const bio = dtls->ssl_ != nullptr ? make_datagram_bio(dtls->ends_) : nullptr;
  if (bio == nullptr) {
    ::ERR_clear_error();
    return nullptr;
  }
  SSL* const ssl = dtls->ssl_;
  ::SSL_set_bio(ssl, bio, bio);
  SSL_set_app_data(ssl, dtls.get());
  ::SSL_set_mtu(ssl, static_cast<long>(kLeastDatagramBytes));
  ::DTLS_set_timer_cb(ssl, next_repeat_us);
  ::SSL_set_accept_state(ssl);
  return dtls;
}

// --- handshake

Dtls::~Dtls() {
  ::SSL_free(ssl_);
}

bool Dtls::check_client_hello(std::span<const std::byte> client_hello, const Cookies& cookies) {
  ::ERR_clear_error();
  ends_.incoming = client_hello;
  cookies_ = &cookies;
  BIO_ADDR* const no_address = ::BIO_ADDR_new();
  has_valid_cookie_ = no_address != nullptr && ::DTLSv1_listen(ssl_, no_address) > 0;
  ::BIO_ADDR_free(no_address);
  cookies_ = nullptr;
  ends_.incoming = {};
  ::ERR_clear_error();
  return has_valid_cookie_;
}

Dtls::Progress Dtls::finish(int outcome) {
  const int error = outcome > 0 ? SSL_ERROR_NONE : ::SSL_get_error(ssl_, outcome);
  ::ERR_clear_error();
  ends_.incoming = {};
  if (error != SSL_ERROR_NONE && error != SSL_ERROR_WANT_READ) {
    broken_ = true;
    return Progress::failed;
  }
  if (::SSL_is_init_finished(ssl_) != 1) return Progress::pending;
  // Requires the extended master secret (RFC 7627), which binds the keys to the whole handshake.
  if (::SSL_get_extms_support(ssl_) != 1) return Progress::failed;
  established_ = true;
  return Progress::established;
}

Dtls::Progress Dtls::handshake(std::span<const std::byte> datagram) {
  ::ERR_clear_error();
  ends_.incoming = datagram;
  return finish(::SSL_do_handshake(ssl_));
}

Dtls::Progress Dtls::repeat_flight() {
  if (established_) return Progress::established;
  ::ERR_clear_error();
  const long repeated = DTLSv1_handle_timeout(ssl_);
  ::ERR_clear_error();
  if (repeated >= 0) return Progress::pending;
  broken_ = true;
  return Progress::failed;
}

int64_t Dtls::timeout_ns() const {
  timeval left{};
  if (established_ || DTLSv1_get_timeout(ssl_, &left) != 1) return kSecondNs;
  return left.tv_sec * kSecondNs + left.tv_usec * (kMillisecondNs / 1000);
}

uint64_t Dtls::nonce() const {
  unsigned char random[sizeof(uint64_t)]{};
  ::SSL_get_client_random(ssl_, random, sizeof random);
  uint64_t nonce = 0;
  for (const unsigned char byte : random) nonce = nonce << 8 | byte;
  return nonce;
}

// --- session

size_t Dtls::seal(std::span<std::byte> datagram, size_t plaintext_at, size_t bytes) {
  if (broken_ || !established_) return 0;
  ::ERR_clear_error();
  ends_.sealed = datagram;
  ends_.sealed_bytes = 0;
  size_t written = 0;
  const int outcome = ::SSL_write_ex(ssl_, &datagram[plaintext_at], bytes, &written);
  ends_.sealed = {};
  if (outcome == 1 && written == bytes) return ends_.sealed_bytes;
  ::ERR_clear_error();
  broken_ = true;
  return 0;
}

Dtls::Opened Dtls::open(std::span<std::byte> datagram, uint64_t record_number,
                        std::span<const std::byte>& plaintext) {
  if (broken_ || !established_) return Opened::forged;
  if (record_number <= newest_record_) {
    const uint64_t behind = newest_record_ - record_number;
    if (behind >= kRecordWindow || (seen_records_ >> behind & 1) != 0) return Opened::repeated;
  }
  ::ERR_clear_error();
  ends_.incoming = datagram;
  size_t got = 0;
  const int outcome = ::SSL_read_ex(ssl_, datagram.data(), datagram.size(), &got);
  ends_.incoming = {};
  if (outcome != 1) {
    const int error = ::SSL_get_error(ssl_, outcome);
    broken_ = error != SSL_ERROR_WANT_READ;
    ::ERR_clear_error();
    return Opened::forged;
  }
  if (record_number > newest_record_) {
    const uint64_t steps = record_number - newest_record_;
    seen_records_ = steps < kRecordWindow ? seen_records_ << steps : 0;
    newest_record_ = record_number;
  }
  seen_records_ |= uint64_t{1} << (newest_record_ - record_number);
  plaintext = datagram.first(got);
  return Opened::plaintext;
}

void Dtls::receive_handshake(std::span<const std::byte> datagram) {
  if (broken_ || !established_) return;
  ::ERR_clear_error();
  ends_.incoming = datagram;
  std::byte nothing;
  size_t got = 0;
  const int outcome = ::SSL_read_ex(ssl_, &nothing, 1, &got);
  ends_.incoming = {};
  broken_ = outcome != 1 && ::SSL_get_error(ssl_, outcome) != SSL_ERROR_WANT_READ;
  ::ERR_clear_error();
}

}  // namespace fire3dv::transport::udp

#include "protocol/transport/udp_seal.h"

#include <sodium.h>

#include <cstring>

#include "protocol/transport/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

static_assert(crypto_aead_chacha20poly1305_ietf_ABYTES == kTagBytes);
static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == 32);

using Nonce = std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;
Nonce nonce_of(uint64_t counter) {
  Nonce nonce{};
  put_le<uint64_t>(reinterpret_cast<std::byte*>(&nonce[4]), counter);
  return nonce;
}

unsigned char* raw(std::byte* bytes) {
  return reinterpret_cast<unsigned char*>(bytes);
}
const unsigned char* raw(const std::byte* bytes) {
  return reinterpret_cast<const unsigned char*>(bytes);
}

// A key for one use, so that what one use gives away helps nobody with another.
void derive(std::array<unsigned char, 32>& key, std::span<const std::byte> from, const char* use) {
  crypto_generichash(key.data(), key.size(), reinterpret_cast<const unsigned char*>(use), std::strlen(use),
                     raw(from.data()), from.size());
}

}  // namespace

Random make_random() {
  Random random;
  randombytes_buf(random.data(), random.size());
  return random;
}

Seal::~Seal() {
  sodium_memzero(own_.data(), own_.size());
  sodium_memzero(others_.data(), others_.size());
}

size_t Seal::seal(std::byte* datagram, size_t bytes, uint64_t counter) const {
  const Nonce nonce = nonce_of(counter);
  unsigned long long sealed = 0;
  unsigned char* payload = raw(datagram + kHeaderBytes);
  crypto_aead_chacha20poly1305_ietf_encrypt(payload, &sealed, payload, bytes - kHeaderBytes, raw(datagram),
                                            kHeaderBytes, nullptr, nonce.data(), own_.data());
  return kHeaderBytes + static_cast<size_t>(sealed);
}

std::optional<std::span<const std::byte>> Seal::open(std::span<std::byte> datagram, uint64_t counter) const {
  if (datagram.size() < kHeaderBytes + kTagBytes) return {};
  const Nonce nonce = nonce_of(counter);
  unsigned long long opened = 0;
  unsigned char* payload = raw(datagram.data() + kHeaderBytes);
  if (crypto_aead_chacha20poly1305_ietf_decrypt(payload, &opened, nullptr, payload,
                                                datagram.size() - kHeaderBytes, raw(datagram.data()),
                                                kHeaderBytes, nonce.data(), others_.data()) != 0)
    return {};
  return datagram.subspan(kHeaderBytes, static_cast<size_t>(opened));
}

Result<std::shared_ptr<const PreSharedKey>> PreSharedKey::from_file(const std::string& path) {
  if (sodium_init() < 0) return Error{"libsodium cannot be set up; the system gives no random numbers"};
  const Result<Secret> secret = read_key_file(path);
  if (!secret) return secret.error();
  return std::shared_ptr<const PreSharedKey>(std::make_shared<PreSharedKey>(*secret));
}

PreSharedKey::PreSharedKey(const Secret& key) {
  derive(proof_key_, key.bytes(), "FIRE-3DV udp 1 proof");
  derive(session_key_, key.bytes(), "FIRE-3DV udp 1 session");
}

PreSharedKey::~PreSharedKey() {
  sodium_memzero(proof_key_.data(), proof_key_.size());
  sodium_memzero(session_key_.data(), session_key_.size());
}

Proof PreSharedKey::prove(std::span<const std::byte> message, std::span<const std::byte> about) const {
  Proof proof;
  crypto_generichash_state state;
  crypto_generichash_init(&state, proof_key_.data(), proof_key_.size(), proof.size());
  crypto_generichash_update(&state, raw(message.data()), message.size());
  crypto_generichash_update(&state, raw(about.data()), about.size());
  crypto_generichash_final(&state, raw(proof.data()), proof.size());
  return proof;
}

bool PreSharedKey::check(const Proof& proof, std::span<const std::byte> message,
                         std::span<const std::byte> about) const {
  const Proof right = prove(message, about);
  return sodium_memcmp(right.data(), proof.data(), proof.size()) == 0;
}

std::unique_ptr<Seal> PreSharedKey::make_seal(Side side, uint64_t session, const Random& publishers,
                                              const Random& listeners) const {
  std::array<std::byte, 8> id;
  put_le<uint64_t>(id.data(), session);
  std::array<unsigned char, 64> keys;
  crypto_generichash_state state;
  crypto_generichash_init(&state, session_key_.data(), session_key_.size(), keys.size());
  crypto_generichash_update(&state, raw(publishers.data()), publishers.size());
  crypto_generichash_update(&state, raw(listeners.data()), listeners.size());
  crypto_generichash_update(&state, raw(id.data()), id.size());
  crypto_generichash_final(&state, keys.data(), keys.size());
  Seal::Key publisher_key, listener_key;
  std::memcpy(publisher_key.data(), keys.data(), 32);
  std::memcpy(listener_key.data(), keys.data() + 32, 32);
  auto seal = side == Side::publisher ? std::make_unique<Seal>(publisher_key, listener_key)
                                      : std::make_unique<Seal>(listener_key, publisher_key);
  sodium_memzero(keys.data(), keys.size());
  sodium_memzero(publisher_key.data(), publisher_key.size());
  sodium_memzero(listener_key.data(), listener_key.size());
  return seal;
}

}  // namespace fire3dv::transport::udp

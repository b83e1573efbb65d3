#include "base/random.h"

#include <sodium.h>

#include <array>
#include <cstring>

namespace fire3dv {
namespace {

using Key = std::array<unsigned char, crypto_shorthash_KEYBYTES>;

Key random_key() {
  FIRE3DV_ASSERT(sodium_init() >= 0);
  Key key{};
  crypto_shorthash_keygen(key.data());
  return key;
}

}  // namespace

uint64_t keyed_hash(std::string_view bytes) {
  static const Key key = random_key();
  std::array<unsigned char, crypto_shorthash_BYTES> hash{};
  crypto_shorthash(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                   key.data());
  uint64_t value = 0;
  static_assert(sizeof value == crypto_shorthash_BYTES);
  std::memcpy(&value, hash.data(), sizeof value);
  return value;
}

}  // namespace fire3dv

// SHA-256 of bytes, by libcrypto: with the CPU's instructions for it where there are some.
#pragma once

#include <openssl/evp.h>

#include <string_view>

#include "base/digest.h"
#include "base/error.h"

namespace fire3dv::drake {

inline Digest sha256_of(std::string_view bytes) {
  Digest digest{};
  unsigned size = 0;
  const int done = EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr);
  FIRE3DV_ASSERT(done == 1 && size == digest.size());
  return digest;
}

}  // namespace fire3dv::drake

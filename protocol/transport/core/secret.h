// Secret files: accepted only if no other user can read them, and never printed.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::transport {

// Bytes that are wiped on destruction.
class Secret {
 public:
  explicit Secret(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  Secret(Secret&&) = default;
  Secret& operator=(Secret&&) = default;
  ~Secret();

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

// Reads a regular file of at most 64 KiB, owned by this user or root and inaccessible to others.
Result<Secret> read_secret_file(const std::string& path);

// Reads a 32-byte pre-shared key: a file with 64 hexadecimal digits, as `openssl rand -hex 32` prints them.
Result<Secret> read_key_file(const std::string& path);

}  // namespace fire3dv::transport

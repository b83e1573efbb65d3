// Key files: read only when nobody else can read them, and never shown.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::transport {

// Bytes that are wiped when they are let go.
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

// A regular file of at most 64 KiB that belongs to this user or root and is closed to everybody else.
Result<Secret> read_secret_file(const std::string& path);

// The 32 bytes of a pre-shared key: a file of 64 hexadecimal digits, as `openssl rand -hex 32` writes it.
Result<Secret> read_key_file(const std::string& path);

}  // namespace fire3dv::transport

#include "protocol/transport/core/secret.h"

#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "base/unique_fd.h"

namespace fire3dv::transport {
namespace {

constexpr size_t kMaxSecretBytes = 64 << 10;

std::string printable_path(const std::string& path) {
  std::string shown = path.substr(0, 200);
  for (char& c : shown)
    if (c < 0x20 || c > 0x7e) c = '?';
  return "key file '" + shown + "'";
}

int hex_digit(std::byte byte) {
  const char c = static_cast<char>(byte);
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

Secret::~Secret() {
  if (!bytes_.empty()) ::explicit_bzero(bytes_.data(), bytes_.size());
}

// Checks owner and mode on the descriptor that is read. O_NONBLOCK: a pipe or device must not block the
// program.
Result<Secret> read_secret_file(const std::string& path) {
  const std::string name = printable_path(path);
  const UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!fd) return Error{name + " cannot be read: " + std::strerror(errno)};
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0 || !S_ISREG(info.st_mode))
    return Error{name + " is not a regular file; name the file that holds the key"};
  if (info.st_uid != ::geteuid() && info.st_uid != 0)
    return Error{name + " belongs to another user; make a copy of your own with mode 600"};
  if ((info.st_mode & 077) != 0)
    return Error{
        name +
        " can be read or written by other users; chmod 600 it, and take a new key if they may know it"};
  if (info.st_size > static_cast<off_t>(kMaxSecretBytes))
    return Error{name + " is larger than 64 KiB; name the file that holds the key"};
  std::vector<std::byte> bytes(static_cast<size_t>(info.st_size));
  size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t count = ::read(fd.get(), bytes.data() + got, bytes.size() - got);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return Error{name + " cannot be read to its end"};
    got += static_cast<size_t>(count);
  }
  return Secret(std::move(bytes));
}

Result<Secret> read_key_file(const std::string& path) {
  const Result<Secret> text = read_secret_file(path);
  if (!text) return text.error();
  std::span<const std::byte> digits = text->bytes();
  while (!digits.empty() && (digits.back() == std::byte{'\n'} || digits.back() == std::byte{'\r'}))
    digits = digits.first(digits.size() - 1);
  std::vector<std::byte> key(32);
  bool sound = digits.size() == 64;
  for (size_t i = 0; sound && i < key.size(); ++i) {
    const int high = hex_digit(digits[2 * i]), low = hex_digit(digits[2 * i + 1]);
    sound = high >= 0 && low >= 0;
    key[i] = static_cast<std::byte>(high << 4 | low);
  }
  Secret secret(std::move(key));
  if (!sound)
    return Error{
        printable_path(path) +
        " does not hold 64 hexadecimal digits; write one with: (umask 077; openssl rand -hex 32 > FILE)"};
  return secret;
}

}  // namespace fire3dv::transport

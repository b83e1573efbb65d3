#include "renderer/browser/server/access.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "base/files.h"
#include "base/random.h"
#include "base/unique_fd.h"
#include "protocol/transport/core/secret.h"

namespace fire3dv::serve {
namespace {

constexpr size_t kTokenDigits = 32;

std::string random_token() {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string token;
  while (token.size() < kTokenDigits) {
    const uint64_t bits = random_id();
    for (int shift = 0; shift < 64; shift += 4) token += kDigits[bits >> shift & 15];
  }
  return token;
}

bool is_token(std::string_view text) {
  return text.size() == kTokenDigits &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;
  for (size_t i = 0; i < a.size(); ++i) difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  return difference == 0;
}

}  // namespace

Tokens random_tokens() {
  return {random_token(), random_token()};
}

Result<Tokens> read_or_create_tokens(const std::filesystem::path& file) {
  const auto failed = [&](const std::string& why) {
    return Error{"--serve-tokens " + file.string() + ": " + why};
  };
  UniqueFd fd(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR));
  if (fd) {
    Tokens tokens = random_tokens();
    const std::string text = tokens.control + "\n" + tokens.view + "\n";
    if (::write(fd.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      const int reason = errno;
      ::unlink(file.c_str());
      return failed("cannot be written: " + system_reason(reason));
    }
    return tokens;
  }
  if (errno != EEXIST) return failed("cannot be created: " + system_reason(errno));
  const Result<transport::Secret> secret = transport::read_secret_file(file.string());
  if (!secret) return failed(secret.error().message);
  const std::string_view text(reinterpret_cast<const char*>(secret->bytes().data()), secret->bytes().size());
  const size_t line = text.find('\n');
  if (line == std::string_view::npos || !text.ends_with('\n') || text.size() < line + 2)
    return failed("must have two lines of 32 hexadecimal digits; remove it, and a new one is created");
  Tokens tokens{std::string(text.substr(0, line)), std::string(text.substr(line + 1))};
  tokens.view.pop_back();
  if (!is_token(tokens.control) || !is_token(tokens.view) || tokens.control == tokens.view)
    return failed(
        "must have two different lines of 32 hexadecimal digits; remove it, and a new one is created");
  return tokens;
}

Access access_of(const Tokens& tokens, std::string_view token) {
  // Both comparisons run in every case.
  const bool is_control = is_equal_in_constant_time(token, tokens.control);
  const bool is_view = is_equal_in_constant_time(token, tokens.view);
  return is_control ? Access::control : is_view ? Access::view : Access::none;
}

}  // namespace fire3dv::serve

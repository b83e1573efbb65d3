#include "adapters/mujoco/command_lines.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace fire3dv::mujoco {

// Ignoring SIGTTIN makes a read from the terminal fail in a background job instead of stopping the program.
CommandLines::CommandLines() {
  std::signal(SIGTTIN, SIG_IGN);
}

std::optional<std::string> CommandLines::next() {
  constexpr size_t kMostBytes = 4096;  // line limit; no command is longer
  if (text_.find('\n') == std::string::npos && !is_over_) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, 0) > 0) {
      char bytes[512];
      const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (count > 0 && text_.size() < kMostBytes) text_.append(bytes, static_cast<size_t>(count));
      is_over_ = count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
    }
  }
  const size_t end = text_.find('\n');
  if (end == std::string::npos) {
    if (text_.size() >= kMostBytes) text_.clear();
    return std::nullopt;
  }
  std::string line = text_.substr(0, end);
  text_.erase(0, end + 1);
  return line;
}

}  // namespace fire3dv::mujoco

// Log lines of all programs on standard error: "PROGRAM: LEVEL: TEXT", with the levels info, warning and
// error. A message carries its level as its first word, since files, panels and parent processes pass
// messages on.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/text.h"

namespace fire3dv {

inline std::string warning(std::string_view text) {
  return "warning: " + std::string(text);
}
inline std::string error_line(std::string_view text) {
  return "error: " + std::string(text);
}

// A message without a level is information.
inline std::string with_level(std::string_view message) {
  for (const std::string_view level : {"info: ", "warning: ", "error: "})
    if (message.starts_with(level)) return std::string(message);
  return "info: " + std::string(message);
}

// Prints one line; control characters are escaped.
inline void print_log_line(const char* program, std::string_view message) {
  std::fprintf(stderr, "%s: %s\n", program, terminal_text(with_level(message)).c_str());
}

// Prints one line of the renderer.
inline void log_message(std::string_view message) {
  print_log_line("fire3dv", message);
}
// Prints an error that ends the renderer, and returns its exit code.
inline int report_failure(const Error& error) {
  log_message(error_line(error.message));
  return 1;
}

}  // namespace fire3dv

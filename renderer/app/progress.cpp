#include "renderer/app/progress.h"

#include <unistd.h>

#include <cstdio>

namespace fire3dv::app {

Progress::Progress(std::string what)
    : what_(std::move(what)), terminal_(isatty(STDERR_FILENO)), last_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (line_open_) std::fprintf(stderr, "\n");
}

void Progress::update(uint64_t done, uint64_t total) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000))) return;
  last_ = now;
  std::fprintf(stderr, "%sfire3dv: %s %llu", terminal_ ? "\r" : "", what_.c_str(),
               static_cast<unsigned long long>(done));
  if (total) std::fprintf(stderr, " of %llu", static_cast<unsigned long long>(total));
  std::fprintf(stderr, terminal_ ? "\033[K" : "\n");
  line_open_ = terminal_;
}

}  // namespace fire3dv::app

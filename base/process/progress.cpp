#include "base/process/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace fire3dv {

namespace {

constexpr std::chrono::seconds kShortJob{1};
constexpr std::chrono::milliseconds kTerminalInterval{200}, kLogInterval{5000};
constexpr size_t kBarWidth = 30;

std::string in_words(double seconds) {
  const auto whole = static_cast<uint64_t>(std::min(seconds + 0.5, 1e9));
  const uint64_t hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return std::to_string(hours) + " h " + std::to_string(minutes) + " min";
  if (minutes > 0) return std::to_string(minutes) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole) + " s";
}

}  // namespace

Progress::Progress(std::string program, std::string what)
    : program_(std::move(program)),
      what_(std::move(what)),
      terminal_(isatty(STDERR_FILENO)),
      begun_(std::chrono::steady_clock::now()),
      last_(begun_) {}

Progress::~Progress() {
  if (line_open_) std::fprintf(stderr, "\n");
}

void Progress::update(uint64_t done, uint64_t total) {
  if (is_due()) show(std::to_string(done) + (total ? " of " + std::to_string(total) : ""));
}

void Progress::update_with_end(uint64_t done, uint64_t total) {
  if (!done_at_first_) done_at_first_ = done;
  if (!is_due()) return;
  const double passed_s = std::chrono::duration<double>(last_ - begun_).count();
  const double per_s = static_cast<double>(done - *done_at_first_) / passed_s;
  std::string text = std::to_string(done) + " of " + std::to_string(total);
  if (per_s > 0) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.3g", per_s);
    text += ", " + std::string(rate) + " a second, " + in_words(static_cast<double>(total - done) / per_s) +
            " left";
  }
  show(text);
}

void Progress::update(const char* stage, uint64_t done, uint64_t total) {
  if (!is_due()) return;
  const double part = total ? std::min(static_cast<double>(done) / static_cast<double>(total), 1.0) : 0;
  const auto filled = static_cast<size_t>(part * static_cast<double>(kBarWidth));
  std::string text = stage;
  if (terminal_) text += " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "]";
  show(text + " " + std::to_string(static_cast<int>(part * 100)) + "%");
}

bool Progress::is_due() {
  const auto now = std::chrono::steady_clock::now();
  if (now - begun_ < kShortJob || now - last_ < (terminal_ ? kTerminalInterval : kLogInterval)) return false;
  last_ = now;
  return true;
}

void Progress::show(const std::string& text) {
  std::fprintf(stderr, "%s%s: info: %s %s%s", terminal_ ? "\r" : "", program_.c_str(), what_.c_str(),
               text.c_str(), terminal_ ? "\033[K" : "\n");
  line_open_ = terminal_;
}

}  // namespace fire3dv

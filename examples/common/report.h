// Status line of a simulator, printed once a second.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "examples/common/publisher.h"

namespace examples {

using Clock = std::chrono::steady_clock;

class Report {
 public:
  void add_step(Clock::duration time) { step_us_.push_back(microseconds(time)); }
  void add_publish(Clock::duration time) { publish_us_.push_back(microseconds(time)); }
  bool due() const { return Clock::now() - since_ >= std::chrono::seconds(1); }
  // Prints the statistics since the last call and resets them.
  void print(double sim_time_s, const std::vector<Publisher::Link>& links);

 private:
  static double microseconds(Clock::duration time) {
    return std::chrono::duration<double, std::micro>(time).count();
  }

  Clock::time_point since_ = Clock::now();
  std::vector<double> step_us_;
  std::vector<double> publish_us_;
  std::vector<std::string> printed_messages_;  // last welcome message per link, so that each is printed once
};

}  // namespace examples

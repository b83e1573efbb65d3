#include "examples/common/report.h"

#include <algorithm>

namespace examples {
namespace {

struct Spread {
  double median = 0, worst = 0;
};

Spread spread_of(std::vector<double>& values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  const double median = *middle;
  return {median, *std::max_element(values.begin(), values.end())};
}

}  // namespace

void Report::print(double sim_time_s, const std::vector<Publisher::Link>& links) {
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - since_).count();
  const size_t frames = publish_us_.size();
  const Spread step = spread_of(step_us_), publish = spread_of(publish_us_);
  std::fprintf(stderr,
               "t %6.2f s  %5.0f frames/s  step median %.0f max %.0f us  publish median %.1f max %.1f us\n",
               sim_time_s, static_cast<double>(frames) / std::max(seconds, 1e-9), step.median, step.worst,
               publish.median, publish.worst);
  printed_messages_.resize(links.size());
  for (size_t i = 0; i < links.size(); ++i) {
    const fire3dv_status& status = links[i].status;
    std::fprintf(stderr, "  %s: renderers %u, published %llu, shown %llu, dropped %llu, unmatched names %u\n",
                 links[i].uri.c_str(), status.renderers,
                 static_cast<unsigned long long>(status.frames_published),
                 static_cast<unsigned long long>(status.acked_sequence),
                 static_cast<unsigned long long>(status.frames_dropped), status.unmatched_names);
    if (status.welcome_message[0] != '\0' && printed_messages_[i] != status.welcome_message) {
      printed_messages_[i] = status.welcome_message;
      std::fprintf(stderr, "  %s: the renderer says: %s\n", links[i].uri.c_str(), status.welcome_message);
    }
  }
  since_ = now;
  step_us_.clear();
  publish_us_.clear();
}

}  // namespace examples

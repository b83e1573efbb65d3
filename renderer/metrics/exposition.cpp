#include "renderer/metrics/exposition.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace fire3dv::metrics {
namespace {

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  char text[64];
  // std::to_chars is independent of the locale, unlike printf. Fixed notation is easier to read for people.
  const bool plain = value == 0 || (std::abs(value) > 1e-9 && std::abs(value) < 1e15);
  const auto [end, error] = std::to_chars(text, text + sizeof text, value,
                                          plain ? std::chars_format::fixed : std::chars_format::scientific);
  return std::string(text, error == std::errc() ? end : text);
}

void append_escaped(std::string& to, std::string_view text) {
  for (const char c : text) {
    if (c == '\\' || c == '"') to += '\\';
    if (c == '\n')
      to += "\\n";
    else
      to += c;
  }
}

}  // namespace

void Histogram::add(double seconds) {
  if (!(seconds >= 0)) return;  // NaN, or a clock that ran backwards
  const auto bound = std::lower_bound(kUpperBounds_s.begin(), kUpperBounds_s.end(), seconds);
  ++buckets_[static_cast<size_t>(bound - kUpperBounds_s.begin())];
  ++count_;
  sum_s_ += seconds;
}

uint64_t Histogram::count_up_to(size_t bound) const {
  uint64_t count = 0;
  for (size_t i = 0; i <= bound; ++i) count += buckets_[i];
  return count;
}

void Exposition::family(std::string_view name, std::string_view type, std::string_view help) {
  family_ = name;
  text_.append("# HELP ").append(name).append(" ").append(help).append("\n# TYPE ");
  text_.append(name).append(" ").append(type).append("\n");
}

void Exposition::line(std::string_view suffix, Labels labels, const Label* more, std::string_view value) {
  text_.append(family_).append(suffix);
  char before = '{';
  const auto append = [&](const Label& label) {
    text_ += std::exchange(before, ',');
    text_.append(label.first).append("=\"");
    append_escaped(text_, label.second);
    text_ += '"';
  };
  for (const Label& label : labels) append(label);
  if (more != nullptr) append(*more);
  if (before == ',') text_ += '}';
  text_.append(" ").append(value).append("\n");
}

void Exposition::sample(std::initializer_list<Label> labels, double value) {
  line("", labels, nullptr, number(value));
}

void Exposition::sample(std::initializer_list<Label> labels, uint64_t value) {
  line("", labels, nullptr, std::to_string(value));
}

void Exposition::histogram(std::initializer_list<Label> labels, const Histogram& histogram) {
  for (size_t i = 0; i < Histogram::kUpperBounds_s.size(); ++i) {
    const std::string bound = number(Histogram::kUpperBounds_s[i]);
    const Label le{"le", bound};
    line("_bucket", labels, &le, std::to_string(histogram.count_up_to(i)));
  }
  const Label le{"le", "+Inf"};
  line("_bucket", labels, &le, std::to_string(histogram.count()));
  summary(labels, histogram.count(), histogram.sum_s());
}

void Exposition::summary(std::initializer_list<Label> labels, uint64_t count, double sum) {
  line("_sum", labels, nullptr, number(sum));
  line("_count", labels, nullptr, std::to_string(count));
}

}  // namespace fire3dv::metrics

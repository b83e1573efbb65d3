// When a link is down: times from the relay's start, as --down has them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::impair {

struct Outage {
  int64_t begin_ns = 0, end_ns = 0;
};

// "AT:FOR" in seconds, such as 5:2.5; nothing when it is something else.
std::optional<Outage> parse_outage(const std::string& text);

bool is_down(const std::vector<Outage>& outages, int64_t since_start_ns);

}  // namespace fire3dv::impair

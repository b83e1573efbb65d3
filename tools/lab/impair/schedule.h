// Outage schedule of option --down: times from the relay's start.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::impair {

struct Outage {
  int64_t begin_ns = 0, end_ns = 0;
};

// Parses "AT:FOR" in seconds, for example 5:2.5. Returns nothing for other text.
std::optional<Outage> parse_outage(const std::string& text);

bool is_down(const std::vector<Outage>& outages, int64_t since_start_ns);

}  // namespace fire3dv::impair

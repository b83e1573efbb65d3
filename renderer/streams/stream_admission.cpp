#include "renderer/streams/stream_admission.h"

#include <algorithm>
#include <cstddef>

namespace fire3dv::app {
namespace {

constexpr int64_t kCalmNs = 10'000'000'000;
constexpr size_t kMaxHosts = 4096;

}  // namespace

std::string host_of_peer(std::string_view budget_name) {
  constexpr std::string_view kFrom = " from ";
  const size_t from = budget_name.rfind(kFrom);
  if (from == std::string_view::npos) return std::string(budget_name);
  std::string_view host = budget_name.substr(from + kFrom.size());
  // "127.0.0.1:7345" and "[::1]:7345" have a port; "::1" has none.
  const size_t colon = host.rfind(':');
  const bool is_bracketed = host.starts_with('[');
  if (colon != std::string_view::npos && (is_bracketed || host.find(':') == colon))
    host = host.substr(0, colon);
  if (is_bracketed && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return std::string(host);
}

std::optional<int64_t> StreamAdmission::wait_until_ns(const std::string& host, int64_t now_ns) {
  if (buckets_.size() >= kMaxHosts && !buckets_.contains(host))
    std::erase_if(buckets_, [&](const auto& entry) { return now_ns - entry.second.filled_ns > kCalmNs; });
  const auto [entry, is_new] = buckets_.try_emplace(host);
  Bucket& bucket = entry->second;
  if (is_new) bucket.filled_ns = now_ns;
  const double seconds = static_cast<double>(now_ns - bucket.filled_ns) * 1e-9;
  bucket.tokens = std::min(kBurst, bucket.tokens + kPerSecond * seconds);
  bucket.filled_ns = now_ns;
  if (bucket.tokens < 1) return now_ns + static_cast<int64_t>((1 - bucket.tokens) / kPerSecond * 1e9) + 1;
  bucket.tokens -= 1;
  return std::nullopt;
}

bool StreamAdmission::take_notice(const std::string& host, int64_t now_ns) {
  std::optional<int64_t>& waited_ns = buckets_[host].waited_ns;
  const bool is_first = !waited_ns || now_ns - *waited_ns > kCalmNs;
  waited_ns = now_ns;
  return is_first;
}

}  // namespace fire3dv::app

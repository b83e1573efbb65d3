// Pace of new streams by host, while other streams are shown: a token bucket for each host. Many adapters may
// start together; one that connects and leaves all the time waits for its next stream.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace fire3dv::app {

// Host of a network peer, without its port, by the first name of its budget ("URI from ADDRESS"); of other
// peers, such as shared-memory segments, the whole name.
std::string host_of_peer(std::string_view budget_name);

class StreamAdmission {
 public:
  static constexpr double kBurst = 64, kPerSecond = 8;

  // Admits a new stream of the host: nullopt. Otherwise the time of the next attempt.
  std::optional<int64_t> wait_until_ns(const std::string& host, int64_t now_ns);
  // True for the first stream of the host that has to wait, until no stream has waited for 10 s.
  bool take_notice(const std::string& host, int64_t now_ns);

 private:
  struct Bucket {
    double tokens = kBurst;
    int64_t filled_ns = 0;
    std::optional<int64_t> waited_ns;  // last time that a stream had to wait
  };
  std::map<std::string, Bucket> buckets_;
};

}  // namespace fire3dv::app

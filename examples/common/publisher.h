// The simulation's end of all its streams: the same frames go to each.
#pragma once

#include <fire3dv/client.hpp>

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace examples {

class Publisher {
 public:
  // The client's exceptions end here: each call returns one sentence on error.
  std::optional<std::string> open(const std::string& adapter_name, const std::vector<std::string>& uris,
                                  const fire3dv::Security& security);
  std::optional<std::string> describe(const fire3dv::Description& description);
  std::optional<std::string> publish(int64_t sim_time_ns, const std::vector<float>& poses,
                                     bool discontinuity);
  // Waits until each stream's last frame was shown. Returns early and without an error once stop is set.
  std::optional<std::string> wait_shown(double timeout_s, const std::atomic<bool>& stop);

  struct Link {
    std::string uri;
    fire3dv_status status{};
  };
  std::vector<Link> poll();

 private:
  struct Target {
    std::string uri;
    fire3dv::Stream stream;
  };
  std::vector<Target> targets_;
  uint64_t sequence_ = 0;  // counts from 1 in the description's epoch, as the library does
};

}  // namespace examples

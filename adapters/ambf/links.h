// The streams that the plugin feeds, all with the same. What fails is said once for each link, not once for
// each step; the others go on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"
#include "fire3dv/scene.h"
#include "protocol/error.h"

namespace fire3dv::ambf {

class Links {
 public:
  // The error names every URI that could not be opened; what could be is open.
  Result<void> open(const Options& options);
  bool empty() const { return links_.empty(); }

  void describe(const std::vector<std::string>& names, double rate_hz);
  // poses: 12 floats for each name. Neither waits nor allocates.
  void publish(double sim_time_s, const std::vector<float>& poses, uint32_t flags);
  // A call of fire3dv/scene.h.
  void edit(const std::function<int(fire3dv_stream*)>& call);
  // Reads answers; renderers' questions about the clock are among them.
  void poll();
  // Says what people should hear of them.
  void tell_answers();
  void close();

 private:
  struct Close {
    void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
  };
  struct Link {
    std::string uri;
    std::unique_ptr<fire3dv_stream, Close> stream;
    std::set<std::string, std::less<>> said;  // failures
    std::string answer;                       // the renderer's last
  };
  static void hear(Link& link, int code);

  std::vector<Link> links_;
};

}  // namespace fire3dv::ambf

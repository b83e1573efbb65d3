// Streams of the plugin, one per URI, all with the same content. A failing stream logs each error once; the
// others continue.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "adapters/ambf/options.h"
#include "base/error.h"
#include "fire3dv/scene.h"

namespace fire3dv::ambf {

class Links {
 public:
  // Opens all URIs. The error names every URI that failed; the others stay open.
  Result<void> open(const Options& options);
  bool empty() const { return links_.empty(); }

  void describe(const std::vector<std::string>& names, double rate_hz);
  // poses: 12 floats per name, row-major. Neither waits nor allocates.
  void publish(double sim_time_s, const std::vector<float>& poses, uint32_t flags);
  // Applies a call of fire3dv/scene.h to all streams.
  void edit(const std::function<int(fire3dv_stream*)>& call);
  // Processes renderers' messages and answers their clock queries.
  void poll();
  // Logs changed answers of renderers.
  void log_answers();
  void close();

 private:
  struct Close {
    void operator()(fire3dv_stream* stream) const { fire3dv_close(&stream); }
  };
  struct Link {
    std::string uri;
    std::unique_ptr<fire3dv_stream, Close> stream;
    std::set<std::string, std::less<>> logged;  // errors logged already
    std::string answer;                         // last answer of a renderer, logged already
  };
  static void check_result(Link& link, int code);

  std::vector<Link> links_;
};

}  // namespace fire3dv::ambf

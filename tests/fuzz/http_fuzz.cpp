// Fuzz target of the metrics server's requests: a complete request gets one valid response, however its bytes
// are split, and an incomplete one is shorter than the limit.
#include <string_view>

#include "base/error.h"
#include "renderer/metrics/request_reader.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const std::string_view text :
       {"GET /metrics HTTP/1.1\r\nHost: localhost:9464\r\nAccept: text/plain;version=0.0.4\r\n\r\n",
        "GET /metrics?x=1 HTTP/1.0\n\n", "POST /metrics HTTP/1.1\r\nContent-Length: 4\r\n\r\nbody",
        "GET /other HTTP/1.0\r\n\r\n", "GET  HTTP/1.0\r\n\r\n", "GET /metrics HTTP/2.0\r\n\r\n"})
    inputs.emplace_back(text.begin(), text.end());
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  const std::string_view request(reinterpret_cast<const char*>(data), size);
  metrics::RequestReader reader;
  const std::optional<unsigned> judged = reader.add(request);
  FIRE3DV_ASSERT(judged || size < metrics::kMaxRequestBytes);
  // A whole header gets its response however it is split.
  if (const size_t end = request.find("\r\n\r\n"); end != std::string_view::npos) {
    const std::string_view header = request.substr(0, end + 4);
    metrics::RequestReader whole, bytewise;
    const std::optional<unsigned> expected = whole.add(header);
    std::optional<unsigned> status;
    for (size_t i = 0; i < header.size() && !status; ++i) status = bytewise.add(header.substr(i, 1));
    FIRE3DV_ASSERT(expected && status && (*expected == 200) == (*status == 200));
  }
  if (!judged) return 0;
  FIRE3DV_ASSERT(*judged == 200 || (*judged >= 400 && *judged <= 505));
  // Only GET /metrics returns the page.
  const bool asked = request.starts_with("GET /metrics HTTP/1.") || request.starts_with("GET /metrics?");
  FIRE3DV_ASSERT(*judged != 200 || asked);
  const metrics::Response response = metrics::make_response(*judged, "page\n");
  FIRE3DV_ASSERT(response.result_int() == *judged && (response.body() == "page\n") == (*judged == 200));
  return 0;
}

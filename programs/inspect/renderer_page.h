// Metrics page of a running renderer: what each of its streams costs. See --metrics of fire3dv.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::inspect {

struct DrawnStream {
  std::string number, name, listener;  // number: as in the page's labels
  double drawing_seconds = 0;          // of its content, while several peers were connected
  double drawing_share = 0;            // of the last seconds, 0 to 1
  bool is_hidden = false;
};

// Streams of a page in Prometheus' text format. Lines of other kinds are skipped.
std::vector<DrawnStream> read_page(std::string_view page);
// Fetches "http://HOST:PORT" or "http://HOST:PORT/metrics". Waits a few seconds at most.
Result<std::string> fetch_page(const std::string& url);

std::string text_of(const std::string& url, const std::vector<DrawnStream>& streams);
std::string json_of(const std::string& url, const std::vector<DrawnStream>& streams);  // one line

}  // namespace fire3dv::inspect

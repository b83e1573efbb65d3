// HTTP request of a metrics scraper: parsing within limits, and the response. Only GET /metrics gets the
// page.
#pragma once

#include <boost/beast/http.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace fire3dv::metrics {

constexpr size_t kMaxRequestBytes = 8 << 10;

class RequestReader {
 public:
  RequestReader();

  // Appends received bytes. Returns the status of the response, once the header is complete or refused; call
  // it no more then.
  std::optional<unsigned> add(std::string_view bytes);

 private:
  std::optional<unsigned> parse();

  boost::beast::http::request_parser<boost::beast::http::empty_body> parser_;
  std::string unparsed_;
  size_t received_bytes_ = 0;
};

using Response = boost::beast::http::response<boost::beast::http::string_body>;
// page: the body of status 200. The connection closes after the response.
Response make_response(unsigned status, std::string&& page);

}  // namespace fire3dv::metrics

#include "renderer/metrics/request_reader.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <cstdint>
#include <limits>
#include <utility>

namespace fire3dv::metrics {
namespace {

namespace http = boost::beast::http;

bool is_printable(char c) {
  return c >= 0x20 && c <= 0x7e;
}

}  // namespace

RequestReader::RequestReader() {
  parser_.header_limit(kMaxRequestBytes);
  parser_.body_limit(std::numeric_limits<uint64_t>::max());  // no body is read
}

std::optional<unsigned> RequestReader::add(std::string_view bytes) {
  // Other protocols are refused by their first byte or line end: the parser could wait for more of them.
  if (received_bytes_ == 0 && !bytes.empty() && !is_printable(bytes.front())) return 400;
  received_bytes_ += bytes.size();
  const size_t start = unparsed_.size();
  unparsed_.append(bytes);
  for (size_t end = unparsed_.find('\n', start); end != std::string::npos;
       end = unparsed_.find('\n', end + 1)) {
    if (end > 0 && unparsed_[end - 1] != '\r') return 400;
  }
  const std::optional<unsigned> status = parse();
  return status || received_bytes_ < kMaxRequestBytes ? status : 431;
}

std::optional<unsigned> RequestReader::parse() {
  boost::system::error_code error;
  unparsed_.erase(0, parser_.put(boost::asio::buffer(unparsed_), error));
  if (error == http::error::need_more) {
    // The parser waits for a version of full length, even if the header ends before.
    if (unparsed_.find("\r\n\r\n") != std::string::npos) return 400;
    return {};
  }
  if (error == http::error::header_limit) return 431;
  if (error == http::error::bad_version) return 505;
  if (error) return 400;
  const auto& request = parser_.get();
  const std::string_view target(request.target().data(), request.target().size());
  if (!std::ranges::all_of(target, is_printable)) return 400;
  if (request.method() != http::verb::get) return 405;
  // Scrapers may add query parameters; they are ignored.
  return target.substr(0, target.find('?')) == "/metrics" ? 200 : 404;
}

Response make_response(unsigned status, std::string&& page) {
  Response response(static_cast<http::status>(status), 10);
  const auto reason = response.reason();
  if (status == 200)
    response.body() = std::move(page);
  else if (status == 404)
    response.body() = "metrics are at /metrics\n";
  else
    response.body() = std::to_string(status) + " " + std::string(reason.data(), reason.size()) + "\n";
  response.set(http::field::content_type,
               status == 200 ? "text/plain; version=0.0.4; charset=utf-8" : "text/plain; charset=utf-8");
  if (status == 405) response.set(http::field::allow, "GET");
  // Stream names are untrusted: nosniff prevents browsers from interpreting them as HTML.
  response.set("X-Content-Type-Options", "nosniff");
  response.set(http::field::cache_control, "no-store");
  response.set(http::field::connection, "close");
  response.prepare_payload();
  return response;
}

}  // namespace fire3dv::metrics

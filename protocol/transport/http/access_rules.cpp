#include "protocol/transport/http/access_rules.h"

#include <arpa/inet.h>

#include <algorithm>

#include "base/text.h"

namespace fire3dv::transport::http {
namespace {

constexpr size_t kMaxHostBytes = 255;
constexpr std::string_view kHttp = "http://", kHttps = "https://";

struct HostPort {
  std::string name;  // lower case, without brackets
  std::string port;  // digits; empty: none is given
};

// HOST or HOST:PORT, as in a Host header; nullopt if malformed.
std::optional<HostPort> split_host(std::string_view text) {
  if (text.empty() || text.size() > kMaxHostBytes) return {};
  size_t end = text.find(':');
  if (text.front() == '[') {
    const size_t bracket = text.find(']');
    if (bracket == std::string_view::npos) return {};
    end = bracket + 1;
    if (end < text.size() && text[end] != ':') return {};
  }
  const std::string_view port = end < text.size() ? text.substr(end + 1) : std::string_view();
  if (!std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; })) return {};
  HostPort host{lower_case(std::string(text.substr(0, end))), std::string(port)};
  if (host.name.starts_with('[')) host.name = host.name.substr(1, host.name.size() - 2);
  return host;
}

bool is_ip_address(const std::string& name) {
  unsigned char address[16];
  return ::inet_pton(AF_INET, name.c_str(), address) == 1 ||
         ::inet_pton(AF_INET6, name.c_str(), address) == 1;
}

// Of a name as DNS has it, or an IP address. Browsers send names of other alphabets as "xn--...".
bool is_host_name(const std::string& name) {
  const bool has_name_characters = std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
  });
  return is_ip_address(name) ||
         (!name.empty() && has_name_characters && !name.starts_with('.') && !name.starts_with('-'));
}

std::string host_of_origin(std::string_view origin) {
  return split_host(origin.substr(origin.find("://") + 3)).value_or(HostPort()).name;
}

Error bad_value(const char* option, const std::string& value, const std::string& why) {
  return Error{std::string(option) + " " + quote(value) + ": " + why};
}

}  // namespace

std::optional<std::string> parse_origin(std::string_view text) {
  if (text.size() > kMaxHostBytes + kHttps.size()) return {};
  const std::string lowered = lower_case(std::string(text));
  const bool is_https = lowered.starts_with(kHttps);
  if (!is_https && !lowered.starts_with(kHttp)) return {};
  const std::string_view scheme = is_https ? kHttps : kHttp;
  const std::string_view place = std::string_view(lowered).substr(scheme.size());
  const std::optional<HostPort> host = split_host(place);
  if (!host || !is_host_name(host->name) || place.ends_with(':')) return {};
  const bool has_brackets = place.starts_with('[');
  if (has_brackets != (host->name.find(':') != std::string::npos)) return {};
  const bool has_default_port = host->port == (is_https ? "443" : "80");
  return std::string(scheme) + (has_brackets ? "[" + host->name + "]" : host->name) +
         (host->port.empty() || has_default_port ? "" : ":" + host->port);
}

Result<AllowedSites> parse_allowed_sites(const std::vector<std::string>& hosts,
                                         const std::vector<std::string>& origins) {
  AllowedSites sites;
  for (const std::string& text : hosts) {
    const std::string name = lower_case(text);
    if (const auto origin = parse_origin(text))
      return bad_value("--allow-host", text, "is an origin; write --allow-origin " + *origin);
    if (!is_host_name(name))
      return bad_value("--allow-host", text,
                       "must be one name without port, path or wildcard, such as sim.example");
    sites.hosts.push_back(name);
  }
  for (const std::string& text : origins) {
    const std::string_view place =
        text.ends_with('/') ? std::string_view(text).substr(0, text.size() - 1) : text;
    std::optional<std::string> origin = parse_origin(place);
    if (origin) {
      sites.origins.push_back(std::move(*origin));
      continue;
    }
    const size_t host = text.find("://");
    const size_t path = host == std::string::npos ? host : text.find('/', host + 3);
    if (path != std::string::npos) origin = parse_origin(std::string_view(text).substr(0, path));
    return bad_value("--allow-origin", text,
                     origin
                         ? "an origin has no path; write --allow-origin " + *origin
                         : "must be http:// or https://, a host and its port if it is not 80 or 443, such as "
                           "https://sim.example");
  }
  return sites;
}

bool AccessRules::allows_host(std::string_view host_header) const {
  if (host_header.empty()) return clients == Clients::programs;
  const std::optional<HostPort> host = split_host(host_header);
  if (!host || host->name.empty()) return false;
  const std::string& name = host->name;
  if (has_tls || is_public || name == "localhost" || name == lower_case(own_host) || is_ip_address(name))
    return true;
  const AllowedSites& sites = options.sites;
  return std::ranges::find(sites.hosts, name) != sites.hosts.end() ||
         std::ranges::any_of(sites.origins,
                             [&](const std::string& origin) { return host_of_origin(origin) == name; });
}

bool AccessRules::allows_origin(std::string_view origin, std::string_view host_header) const {
  const std::optional<std::string> known = parse_origin(origin);
  if (!known) return false;
  if (known == parse_origin(std::string(has_tls ? kHttps : kHttp) + std::string(host_header))) return true;
  const std::vector<std::string>& allowed = options.sites.origins;
  return std::ranges::find(allowed, *known) != allowed.end();
}

std::string host_refusal(std::string_view host_header) {
  if (host_header.empty()) return "the request has no Host header";
  const std::optional<HostPort> host = split_host(host_header);
  const bool is_name = host && is_host_name(host->name);
  return "the Host header " + quote(host_header) + " is not allowed" +
         (is_name ? "; start with --allow-host " + host->name : "");
}

std::string origin_refusal(std::string_view origin) {
  if (origin.empty()) return "a WebSocket needs the Origin header of its page, and this request has none";
  const std::optional<std::string> known = parse_origin(origin);
  if (!known) return "origin " + quote(origin) + " cannot be allowed: it has no host";
  return "origin " + *known + " is not allowed; start with --allow-origin " + *known;
}

}  // namespace fire3dv::transport::http

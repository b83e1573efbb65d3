// Access rules of HTTP servers: checks of the Host and Origin headers, which keep other web sites out of a
// server that the user's browser can reach. A Host that only DNS rebinding can produce is refused, and so is
// the Origin of a foreign page. Headers that a proxy adds (X-Forwarded-...) count for nothing: any client can
// write them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::transport::http {

// Values of --allow-host and --allow-origin, in normal form: lower case, no port that is the scheme's
// default.
struct AllowedSites {
  std::vector<std::string> hosts;    // names without a port
  std::vector<std::string> origins;  // "https://sim.example:8443"
};
// The error names the option, its value and the right form.
Result<AllowedSites> parse_allowed_sites(const std::vector<std::string>& hosts,
                                         const std::vector<std::string>& origins);

// Normal form of an origin "SCHEME://HOST[:PORT]" of http or https; nullopt if it is none.
std::optional<std::string> parse_origin(std::string_view text);

// What the user and the program set for each server.
struct AccessOptions {
  AllowedSites sites;
  std::function<void(const std::string&)> log = {};  // why requests are refused; on the server's thread
};

struct AccessRules {
  enum class Clients : bool {
    browsers,  // Host must be there; pages open WebSockets, whose Origin must be allowed
    programs,  // a request without Host is no browser's; an Origin must be allowed wherever it is sent
  };

  std::string own_host;    // that the user told the server to listen at
  bool has_tls = false;    // the browser has checked the host's name against the certificate: any is accepted
  bool is_public = false;  // programs: reachable by other machines, which know this one by any name
  Clients clients = Clients::browsers;
  AccessOptions options = {};

  // An IP address, localhost, the own host, or a host that the user allowed, also by an origin.
  bool allows_host(std::string_view host_header) const;
  // The server itself, or an origin that the user allowed. Origins are exact: scheme, host and port.
  bool allows_origin(std::string_view origin, std::string_view host_header) const;
};

// Why a request is refused, and which option allows it. For logs, answers and the live view's page.
std::string host_refusal(std::string_view host_header);
std::string origin_refusal(std::string_view origin);

}  // namespace fire3dv::transport::http

// Hosts and IP addresses in texts: the parts of an address, and their replacement.
#pragma once

#include <string>
#include <string_view>

namespace fire3dv::doctor {

bool is_ip_address(const std::string& text);
// Loopback addresses, those of all interfaces, and "localhost".
bool names_this_machine(std::string_view host);

// USER:PASSWORD and HOST of "USER:PASSWORD@HOST:PORT/PATH". The user, the port and the path may be missing,
// and so may the brackets around a host of IPv6.
struct Authority {
  std::string user_info, host;
};
Authority parse_authority(std::string_view text);

// Replaces hosts of URIs by "HOST", IP addresses by "IP", and users of URIs by "USER". What names this
// machine, and the names of shm:// and file://, stay.
void replace_addresses(std::string& text);

}  // namespace fire3dv::doctor

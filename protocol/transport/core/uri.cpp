#include "protocol/transport/core/uri.h"

#include <algorithm>
#include <charconv>

namespace fire3dv::transport {
namespace {

constexpr size_t kMaxUriBytes = 512;  // a host name has at most 253 bytes
constexpr size_t kMaxShmNameBytes = 64;
constexpr size_t kMaxInterfaceBytes = 15;  // limit of Linux
constexpr uint16_t kLeastMtu = 576, kMaxMtu = 9000;

// Sanitises a URI for messages: it may come from a peer's file.
std::string printable(std::string_view text) {
  std::string shown(text.substr(0, 80));
  for (char& c : shown)
    if (c < 0x20 || c > 0x7e) c = '?';
  if (text.size() > shown.size()) shown += "...";
  return shown;
}

Error bad_uri(std::string_view text, std::string_view reason) {
  return Error{"'" + printable(text) + "' is not a link: " + std::string(reason) +
               "; use shm://NAME, tcp://HOST:PORT, tls://HOST:PORT or udp://HOST:PORT"};
}

bool is_alnum(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_shm_name_char(char c) {
  return is_alnum(c) || c == '_' || c == '.' || c == '-';
}
bool is_host_char(char c) {
  return is_alnum(c) || c == '.' || c == '-' || c == '_';
}
bool is_ipv6_char(char c) {
  return is_alnum(c) || c == ':' || c == '.' || c == '%' || c == '-' || c == '_';
}

bool all_of(std::string_view text, bool (*allowed)(char)) {
  return std::all_of(text.begin(), text.end(), allowed);
}

Result<Uri> parse_shm(std::string_view text, std::string_view name) {
  if (name.empty()) return bad_uri(text, "the name after shm:// is missing");
  if (name.size() > kMaxShmNameBytes) return bad_uri(text, "the name is longer than 64 characters");
  if (name.front() == '.') return bad_uri(text, "the name starts with a dot");
  if (!all_of(name, is_shm_name_char))
    return bad_uri(text, "the name has a character other than letters, digits, '_', '.' and '-'");
  Uri uri;
  uri.scheme = Uri::Scheme::shm;
  uri.name = name;
  return uri;
}

template <typename Number>
bool parse_number(std::string_view text, Number least, Number most, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size() && number >= least && number <= most;
}

bool is_interface_char(char c) {
  return is_host_char(c) || c == '@' || c == ':';
}

// Parses "mtu=1400&ttl=2"; each option at most once.
Result<void> parse_options(std::string_view text, std::string_view options, Uri& uri) {
  while (true) {
    const size_t end = options.find('&');
    const std::string_view option = options.substr(0, end);
    const size_t equals = option.find('=');
    const std::string_view name = option.substr(0, equals);
    const std::string_view value =
        equals == std::string_view::npos ? std::string_view() : option.substr(equals + 1);
    if (name == "mtu" && uri.mtu == 0) {
      if (!parse_number(value, kLeastMtu, kMaxMtu, uri.mtu))
        return bad_uri(text, "mtu is not a number from 576 to 9000");
    } else if (name == "ttl" && uri.ttl == 0) {
      if (!parse_number<uint8_t>(value, 1, 255, uri.ttl))
        return bad_uri(text, "ttl is not a number from 1 to 255");
    } else if (name == "interface" && uri.interface.empty()) {
      if (value.empty() || value.size() > kMaxInterfaceBytes || !all_of(value, is_interface_char))
        return bad_uri(text, "the interface has a name that no interface has");
      uri.interface = value;
    } else {
      return bad_uri(text, "the option '" + printable(name) +
                               "' is not known or stands there twice (udp:// has mtu, ttl and interface)");
    }
    if (end == std::string_view::npos) return {};
    options.remove_prefix(end + 1);
  }
}

Result<Uri> parse_host_and_port(std::string_view text, Uri::Scheme scheme, std::string_view rest) {
  Uri uri;
  uri.scheme = scheme;
  if (const size_t mark = rest.find('?'); mark != std::string_view::npos && scheme == Uri::Scheme::udp) {
    if (auto options = parse_options(text, rest.substr(mark + 1), uri); !options) return options.error();
    rest = rest.substr(0, mark);
  }
  std::string_view port;
  if (!rest.empty() && rest.front() == '[') {
    const size_t end = rest.find(']');
    if (end == std::string_view::npos) return bad_uri(text, "the ']' after the IPv6 address is missing");
    uri.host = rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
    if (rest.empty() || rest.front() != ':') return bad_uri(text, "the port is missing");
    port = rest.substr(1);
    if (!all_of(uri.host, is_ipv6_char)) return bad_uri(text, "the host in brackets is not an IPv6 address");
  } else {
    const size_t colon = rest.find(':');
    if (colon == std::string_view::npos) return bad_uri(text, "the port is missing");
    uri.host = rest.substr(0, colon);
    port = rest.substr(colon + 1);
    if (port.find(':') != std::string_view::npos)
      return bad_uri(text, "an IPv6 address stands in brackets, as in tcp://[::1]:7345");
    if (!all_of(uri.host, is_host_char))
      return bad_uri(text, "the host has a character that no host name has");
  }
  if (uri.host.empty()) return bad_uri(text, "the host is missing");
  if (!parse_number<uint16_t>(port, 0, UINT16_MAX, uri.port))
    return bad_uri(text, "the port is not a number from 0 to 65535");
  return uri;
}

}  // namespace

Result<Uri> parse_uri(std::string_view text) {
  if (text.size() > kMaxUriBytes) return bad_uri(text, "it is longer than 512 characters");
  const size_t colon = text.find("://");
  if (colon == std::string_view::npos) return bad_uri(text, "it has no scheme");
  const std::string_view scheme = text.substr(0, colon);
  const std::string_view rest = text.substr(colon + 3);
  if (scheme == "shm") return parse_shm(text, rest);
  if (scheme == "tcp") return parse_host_and_port(text, Uri::Scheme::tcp, rest);
  if (scheme == "tls") return parse_host_and_port(text, Uri::Scheme::tls, rest);
  if (scheme == "udp") return parse_host_and_port(text, Uri::Scheme::udp, rest);
  return bad_uri(text, "the scheme '" + printable(scheme) + "' is not known");
}

}  // namespace fire3dv::transport

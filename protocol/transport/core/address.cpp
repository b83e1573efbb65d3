#include "protocol/transport/core/address.h"

#include <arpa/inet.h>
#include <netdb.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <thread>
#include <utility>

#include "base/random.h"

namespace fire3dv::transport {
namespace {

constexpr size_t kMaxUriBytes = 512;  // a host name has at most 253 bytes
constexpr size_t kMaxShmNameBytes = 64;
constexpr size_t kMaxInterfaceBytes = 15;  // limit of Linux
constexpr uint16_t kLeastMtu = 576, kMaxMtu = 9000;
constexpr uint8_t kMaxParityPercent = 200;

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

// Parses "auto", "off" or a percentage.
bool parse_parity(std::string_view text, std::optional<uint8_t>& percent) {
  uint8_t number = 0;
  if (text != "auto" && text != "off" && !parse_number<uint8_t>(text, 1, kMaxParityPercent, number))
    return false;
  if (text != "auto") percent = number;
  return true;
}

// Parses "mtu=1400&ttl=2"; each option at most once.
Result<void> parse_options(std::string_view text, std::string_view options, Uri& uri) {
  bool has_parity = false;
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
    } else if (name == "parity" && !has_parity) {
      has_parity = true;
      if (!parse_parity(value, uri.parity_percent))
        return bad_uri(text, "parity is neither auto, nor off, nor a number of percent from 1 to 200");
    } else if (name == "ttl" && uri.ttl == 0) {
      if (!parse_number<uint8_t>(value, 1, 255, uri.ttl))
        return bad_uri(text, "ttl is not a number from 1 to 255");
    } else if (name == "interface" && uri.interface.empty()) {
      if (value.empty() || value.size() > kMaxInterfaceBytes || !all_of(value, is_interface_char))
        return bad_uri(text, "the interface has a name that no interface has");
      uri.interface = value;
    } else {
      return bad_uri(text,
                     "the option '" + printable(name) +
                         "' is not known or stands there twice (udp:// has mtu, parity, ttl and interface)");
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

namespace {

const in_addr& ipv4(const sockaddr_storage& storage) {
  return reinterpret_cast<const sockaddr_in&>(storage).sin_addr;
}
const in6_addr& ipv6(const sockaddr_storage& storage) {
  return reinterpret_cast<const sockaddr_in6&>(storage).sin6_addr;
}

uint32_t scope_of(const sockaddr_storage& storage) {
  return reinterpret_cast<const sockaddr_in6&>(storage).sin6_scope_id;
}

int look_up(const Uri& uri, int type, int flags, std::vector<Address>& found) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = type;
  hints.ai_flags = AI_NUMERICSERV | flags;
  addrinfo* list = nullptr;
  // RFC 6761: localhost is the loopback address, independent of hosts files and name servers.
  const bool local = uri.host == "localhost";
  const std::string host = local ? "127.0.0.1" : uri.host;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(uri.port).c_str(), &hints, &list);
  if (error != 0) return error;
  for (const addrinfo* entry = list; entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_addrlen > sizeof(sockaddr_storage)) continue;
    Address address;
    std::memcpy(&address.storage, entry->ai_addr, entry->ai_addrlen);
    address.length = entry->ai_addrlen;
    found.push_back(address);
  }
  ::freeaddrinfo(list);
  return found.empty() ? EAI_NONAME : 0;
}

int socket_type(const Uri& uri) {
  return uri.scheme == Uri::Scheme::udp ? SOCK_DGRAM : SOCK_STREAM;
}

}  // namespace

bool Address::is_loopback() const {
  if (family() == AF_INET) return (ntohl(ipv4(storage).s_addr) >> 24) == 127;
  if (family() != AF_INET6) return false;
  const in6_addr& address = ipv6(storage);
  if (IN6_IS_ADDR_V4MAPPED(&address)) return address.s6_addr[12] == 127;
  return IN6_IS_ADDR_LOOPBACK(&address);
}

uint16_t Address::port() const {
  return ntohs(family() == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(storage).sin6_port
                                    : reinterpret_cast<const sockaddr_in&>(storage).sin_port);
}

std::string Address::text() const {
  char host[INET6_ADDRSTRLEN] = "?";
  if (family() == AF_INET6) {
    ::inet_ntop(AF_INET6, &ipv6(storage), host, sizeof host);
    const uint32_t scope = scope_of(storage);
    return "[" + std::string(host) + (scope != 0 ? "%" + std::to_string(scope) : "") +
           "]:" + std::to_string(port());
  }
  ::inet_ntop(AF_INET, &ipv4(storage), host, sizeof host);
  return std::string(host) + ":" + std::to_string(port());
}

// Compares fields, not bytes: padding and flow labels do not distinguish peers.
bool Address::operator==(const Address& other) const {
  if (family() != other.family() || port() != other.port()) return false;
  if (family() == AF_INET) return ipv4(storage).s_addr == ipv4(other.storage).s_addr;
  // A link-local address is unique only together with its scope.
  return std::memcmp(&ipv6(storage), &ipv6(other.storage), sizeof(in6_addr)) == 0 &&
         scope_of(storage) == scope_of(other.storage);
}

bool Address::is_same_host(const Address& other) const {
  if (family() != other.family()) return false;
  if (family() == AF_INET) return ipv4(storage).s_addr == ipv4(other.storage).s_addr;
  const size_t bytes = IN6_IS_ADDR_V4MAPPED(&ipv6(storage)) ? sizeof(in6_addr) : sizeof(in6_addr) / 2;
  return std::memcmp(&ipv6(storage), &ipv6(other.storage), bytes) == 0;
}

size_t AddressHash::operator()(const Address& address) const {
  struct {
    in6_addr host{};
    uint32_t scope = 0;
    uint16_t port = 0, family = 0;
  } key;
  key.port = address.port();
  key.family = static_cast<uint16_t>(address.family());
  if (address.family() == AF_INET) {
    std::memcpy(&key.host, &ipv4(address.storage), sizeof(in_addr));
  } else {
    key.host = ipv6(address.storage);
    key.scope = scope_of(address.storage);
  }
  return keyed_hash({reinterpret_cast<const char*>(&key), sizeof key});
}

std::string uri_text(const Uri& uri) {
  const bool brackets = uri.host.find(':') != std::string::npos;
  const std::string scheme = uri.scheme == Uri::Scheme::udp   ? "udp://"
                             : uri.scheme == Uri::Scheme::tls ? "tls://"
                                                              : "tcp://";
  std::string text =
      scheme + (brackets ? "[" : "") + uri.host + (brackets ? "]:" : ":") + std::to_string(uri.port);
  char before = '?';
  const auto option = [&](const char* name, const std::string& value) {
    text += std::exchange(before, '&') + std::string(name) + "=" + value;
  };
  if (uri.mtu != 0) option("mtu", std::to_string(uri.mtu));
  if (uri.parity_percent)
    option("parity", *uri.parity_percent == 0 ? "off" : std::to_string(*uri.parity_percent));
  if (uri.ttl != 0) option("ttl", std::to_string(uri.ttl));
  if (!uri.interface.empty()) option("interface", uri.interface);
  return text;
}

struct Lookup::Answer {
  std::vector<Address> addresses;
  std::string problem;
  std::atomic<bool> done{false};
};

// Resolves a name on a detached thread, which shares ownership of the answer, so that the caller need not
// wait. A numeric address is resolved immediately.
Lookup::Lookup(const Uri& uri) : answer_(std::make_shared<Answer>()) {
  if (look_up(uri, socket_type(uri), AI_NUMERICHOST, answer_->addresses) == 0) {
    answer_->done.store(true, std::memory_order_release);
    return;
  }
  std::thread([uri, answer = answer_] {
    const int error = look_up(uri, socket_type(uri), 0, answer->addresses);
    if (error != 0) answer->problem = "the host '" + uri.host + "' is not known: " + ::gai_strerror(error);
    answer->done.store(true, std::memory_order_release);
  }).detach();
}

Lookup::Lookup(const Uri& uri, NumericOnly) : answer_(std::make_shared<Answer>()) {
  look_up(uri, socket_type(uri), AI_NUMERICHOST, answer_->addresses);
  answer_->done.store(true, std::memory_order_release);
}

bool Lookup::done() const {
  return answer_->done.load(std::memory_order_acquire);
}
std::vector<Address> Lookup::addresses() const {
  return answer_->addresses;
}
std::string Lookup::problem() const {
  return answer_->problem;
}

Result<BoundSocket> bind_listener(const Uri& uri, int type, bool may_be_public) {
  const std::string name = uri_text(uri);
  std::vector<Address> found;
  if (const int error = look_up(uri, type, AI_PASSIVE, found); error != 0)
    return Error{name + ": the host is not known (" + ::gai_strerror(error) +
                 "); use an address of this machine"};
  const Address& wanted = found.front();
  if (!wanted.is_loopback() && !may_be_public)
    return Error{name +
                 ": listening on an address other than loopback lets anyone on the network send; use " +
                 (wanted.family() == AF_INET6 ? "[::1]" : "127.0.0.1") + ", or " +
                 (type == SOCK_DGRAM ? "a key (key file), " : "tls:// with a certificate, ") +
                 "or --insecure if that is wanted"};
  BoundSocket bound;
  bound.fd = UniqueFd(::socket(wanted.family(), type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!bound.fd) return Error{name + ": cannot make a socket: " + std::strerror(errno)};
  const int on = 1;
  // TCP: allows a port with connections in TIME_WAIT. UDP: not set, as it would let two sockets share a port.
  if (type == SOCK_STREAM) ::setsockopt(bound.fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (wanted.family() == AF_INET6) ::setsockopt(bound.fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &on, sizeof on);
  if (::bind(bound.fd.get(), wanted.get(), wanted.length) != 0 ||
      (type == SOCK_STREAM && ::listen(bound.fd.get(), SOMAXCONN) != 0)) {
    if (errno == EADDRINUSE)
      return Error{name + ": the port is in use; stop the program that listens there or choose another port"};
    if (errno == EADDRNOTAVAIL)
      return Error{name + ": the address is not one of this machine; use one of its own or 127.0.0.1"};
    if (errno == EACCES) return Error{name + ": ports below 1024 are for root; choose another port"};
    return Error{name + ": cannot listen: " + std::strerror(errno)};
  }
  bound.address.length = sizeof bound.address.storage;
  if (::getsockname(bound.fd.get(), bound.address.get(), &bound.address.length) != 0)
    return Error{name + ": cannot read the chosen port: " + std::strerror(errno)};
  return bound;
}

}  // namespace fire3dv::transport

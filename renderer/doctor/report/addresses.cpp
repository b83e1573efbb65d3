#include "renderer/doctor/report/addresses.h"

#include <arpa/inet.h>

#include <algorithm>

#include "base/text.h"
#include "renderer/doctor/report/characters.h"

namespace fire3dv::doctor {
namespace {

// By these an address may end that is part of a sentence.
std::string_view without_end_marks(std::string_view text) {
  while (text.ends_with('.') || text.ends_with(':')) text.remove_suffix(1);
  return text;
}

std::string shown_host(const std::string& host) {
  if (host.empty() || names_this_machine(host)) return host;
  return is_ip_address(host) ? "IP" : "HOST";
}

void replace_uri_hosts(std::string& text) {
  constexpr std::string_view kMark = "://", kEnds = " \t\r\n\"'`,;()<>";
  for (size_t mark = text.find(kMark); mark != std::string::npos; mark = text.find(kMark, mark + 1)) {
    size_t scheme = mark;
    while (scheme > 0 && is_alphanumeric(text[scheme - 1])) --scheme;
    const std::string_view name = std::string_view(text).substr(scheme, mark - scheme);
    if (name == "shm" || name == "file") continue;
    const size_t begin = mark + kMark.size(), end = std::min(text.find_first_of(kEnds, begin), text.size());
    std::string uri(without_end_marks(std::string_view(text).substr(begin, end - begin)));
    const size_t bytes = uri.size();
    const auto [user_info, host] = parse_authority(uri);
    const size_t host_at = uri.find(host, user_info.empty() ? 0 : user_info.size() + 1);
    uri.replace(host_at, host.size(), shown_host(host));
    if (!user_info.empty()) uri.replace(0, user_info.size(), "USER");
    text.replace(begin, bytes, uri);
  }
}

// The IP address at the beginning of a run of its characters: the rest is a port or the screen of a display.
// Empty: there is none.
std::string leading_ip_address(std::string run, bool is_version_6) {
  run = without_end_marks(run);
  if (is_ip_address(run)) return run;
  if (!is_version_6 || run.find("::") == std::string::npos) return "";
  run.resize(std::min(run.rfind('.'), run.size()));
  if (is_ip_address(run)) return run;
  run.resize(std::min(run.rfind(':'), run.size()));
  return is_ip_address(run) ? run : "";
}

void replace_ip_addresses(std::string& text) {
  constexpr std::string_view kFour = "0123456789.", kSix = "0123456789abcdefABCDEF:.";
  for (const std::string_view characters : {kSix, kFour}) {
    const bool is_version_6 = characters == kSix;
    for (size_t at = text.find_first_of(characters); at != std::string::npos;
         at = text.find_first_of(characters, at)) {
      const size_t end = std::min(text.find_first_not_of(characters, at), text.size());
      const std::string address = leading_ip_address(text.substr(at, end - at), is_version_6);
      // "/a::/b" is a path.
      const bool is_alone =
          (at == 0 || (!is_name_character(text[at - 1]) && (!is_version_6 || text[at - 1] != '/'))) &&
          (end == text.size() || !is_name_character(text[end]));
      if (is_alone && !address.empty() && !names_this_machine(address)) {
        text.replace(at, address.size(), "IP");
        at += 2;
      } else {
        at = end;
      }
    }
  }
}

}  // namespace

bool is_ip_address(const std::string& text) {
  in_addr four{};
  in6_addr six{};
  return ::inet_pton(AF_INET, text.c_str(), &four) == 1 || ::inet_pton(AF_INET6, text.c_str(), &six) == 1;
}

bool names_this_machine(std::string_view host) {
  return host.starts_with("127.") || host == "0.0.0.0" || host == "::1" || host == "::" ||
         lower_case(std::string(host)) == "localhost";
}

Authority parse_authority(std::string_view text) {
  Authority parts;
  // First the user: a password may have any sign.
  if (const size_t at = text.rfind('@'); at != std::string_view::npos) {
    parts.user_info = text.substr(0, at);
    text.remove_prefix(at + 1);
  }
  text = text.substr(0, text.find_first_of("/?#"));
  if (text.starts_with('[')) {
    text.remove_prefix(1);
    parts.host = text.substr(0, text.find(']'));
  } else {
    parts.host = is_ip_address(std::string(text)) ? text : text.substr(0, text.rfind(':'));
  }
  return parts;
}

void replace_addresses(std::string& text) {
  replace_uri_hosts(text);
  replace_ip_addresses(text);
}

}  // namespace fire3dv::doctor

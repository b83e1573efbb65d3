#include "renderer/doctor/report/redaction.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "renderer/doctor/report/addresses.h"
#include "renderer/doctor/report/characters.h"

namespace fire3dv::doctor {
namespace {

constexpr size_t kMinName = 2;  // one letter names nobody, and is a word

// Names that many users and machines have, and words that the report needs: drivers, groups, device nodes.
constexpr std::string_view kCommon[] = {
    "admin",   "administrator", "amd",     "build",  "builder",  "container", "cpu",    "cuda",    "debian",
    "default", "dev",           "display", "docker", "ec2-user", "error",     "fedora", "file",    "fire3dv",
    "gpu",     "guest",         "home",    "host",   "intel",    "jenkins",   "lib",    "linux",   "llvmpipe",
    "local",   "mesa",          "mnt",     "nobody", "note",     "nvidia",    "ok",     "opt",     "render",
    "root",    "runner",        "sandbox", "server", "share",    "shm",       "sudo",   "system",  "test",
    "tester",  "tmp",           "ubuntu",  "unix",   "usr",      "user",      "users",  "vagrant", "video",
    "vulkan",  "warning",       "windows", "worker", "workspace"};

struct Name {
  std::string lower;
  bool is_host = false;
};

// The longest first: "ada-thinkpad" before "ada".
std::vector<Name> names_by_length(const PrivateWords& words) {
  std::vector<Name> names;
  for (const std::string& user : words.users) names.push_back({lower_case(user), false});
  for (const std::string& host : words.hosts) names.push_back({lower_case(host), true});
  std::erase_if(names, [](const Name& name) { return name.lower.empty(); });
  std::stable_sort(names.begin(), names.end(),
                   [](const Name& a, const Name& b) { return a.lower.size() > b.lower.size(); });
  return names;
}

size_t end_of_name(std::string_view text, size_t at) {
  while (at < text.size() && is_name_character(text[at])) ++at;
  while (at > 0 && text[at - 1] == '.') --at;  // of a sentence
  return at;
}

// The end of a host's domain, or of the host in USER@HOST.
size_t end_of_address(std::string_view text, size_t end, bool is_host) {
  const auto begins_name = [&](size_t at) { return at < text.size() && is_alphanumeric(text[at]); };
  const bool goes_on = end < text.size() && text[end] == (is_host ? '.' : '@') && begins_name(end + 1);
  return goes_on ? end_of_name(text, end + 1) : end;
}

// Names stand alone or as a part of longer ones: "ada" in "ada-2", "lab" in "lab.example.org". One pass: what
// stands for a name is no name.
std::string replace_names(const std::string& text, const std::vector<Name>& names) {
  const std::string lower = lower_case(text);
  std::string result;
  for (size_t at = 0; at < text.size();) {
    const bool begins = at == 0 || !is_alphanumeric(text[at - 1]);
    const auto is_here = [&](const Name& name) {
      const size_t end = at + name.lower.size();
      return lower.compare(at, name.lower.size(), name.lower) == 0 &&
             (end >= text.size() || !is_alphanumeric(text[end]));
    };
    const auto name = begins ? std::find_if(names.begin(), names.end(), is_here) : names.end();
    if (name == names.end()) {
      result += text[at++];
      continue;
    }
    const size_t end = at + name->lower.size();
    at = end_of_address(text, end, name->is_host);
    result += name->is_host ? "HOST" : "USER";
    if (!name->is_host && at > end) result += "@HOST";
  }
  return result;
}

void replace_home(std::string& text, const std::string& home) {
  for (size_t at = text.find(home); at != std::string::npos; at = text.find(home, at + 1)) {
    const size_t end = at + home.size();
    if ((at == 0 || !is_name_character(text[at - 1])) &&
        (end == text.size() || !is_name_character(text[end])))
      text.replace(at, home.size(), "~");
  }
}

// Folders of other users, in whole.
void replace_other_homes(std::string& text) {
  constexpr std::string_view kFolder = "/home/", kEnds = "/:;,\"' \n)";
  for (size_t at = text.find(kFolder); at != std::string::npos; at = text.find(kFolder, at + 1)) {
    const size_t begin = at + kFolder.size();
    const size_t end = std::min(text.find_first_of(kEnds, begin), text.size());
    text.replace(begin, end - begin, "USER");
  }
}

void add(std::vector<std::string>& list, const std::string& word) {
  if (!word.empty() && word != "/" && std::find(list.begin(), list.end(), word) == list.end())
    list.push_back(word);
}

void add_name(std::vector<std::string>& list, const std::string& name) {
  const bool is_common =
      std::find(std::begin(kCommon), std::end(kCommon), lower_case(name)) != std::end(kCommon);
  if (name.size() >= kMinName && !is_common) add(list, name);
}

void add_home(PrivateWords& words, std::string folder) {
  while (folder.ends_with('/')) folder.pop_back();
  if (folder.empty()) return;
  std::error_code ignored;
  const std::string real = std::filesystem::canonical(folder, ignored).string();
  add(words.homes, folder);
  add(words.homes, real);
}

void add_host(PrivateWords& words, const std::string& name) {
  if (is_ip_address(name)) return;
  for (const std::string& host : {name, name.substr(0, name.find('.'))}) {
    if (!names_this_machine(host)) add_name(words.hosts, host);
  }
}

// "ada", "CORP\ada" and "ada@corp.example.org".
void add_user(PrivateWords& words, std::string name) {
  if (const size_t at = name.find('@'); at != std::string::npos) {
    add_host(words, name.substr(at + 1));
    name.resize(at);
  }
  if (const size_t slash = name.rfind('\\'); slash != std::string::npos) {
    add_host(words, name.substr(0, slash));
    name.erase(0, slash + 1);
  }
  add_name(words.users, name);
}

// Of "tcp://USER:PASSWORD@HOST:PORT", "HOST:PORT" and "HOST".
void add_address(PrivateWords& words, std::string_view address) {
  if (address.starts_with("shm://")) return;
  if (const size_t mark = address.find("://"); mark != std::string_view::npos)
    address.remove_prefix(mark + 3);
  const auto [user_info, host] = parse_authority(address);
  add_host(words, host);
  const size_t colon = user_info.find(':');
  add_user(words, user_info.substr(0, colon));
  if (colon != std::string::npos) add_name(words.users, user_info.substr(colon + 1));
}

// Of "[PROTOCOL/]HOST:NUMBER"; a path is a socket of this machine.
void add_display(PrivateWords& words, std::string_view display) {
  if (display.starts_with('/')) return;
  display.remove_prefix(display.find('/') + 1);  // npos + 1 is 0
  std::string host = parse_authority(display).host;
  while (host.ends_with(':')) host.pop_back();  // of DECnet
  add_host(words, host);
}

}  // namespace

PrivateWords private_words(const Facts& facts) {
  PrivateWords words;
  add_home(words, facts.variable("HOME"));
  for (const char* name : {"USER", "LOGNAME", "SUDO_USER", "USERNAME"}) add_user(words, facts.variable(name));
  for (const uid_t user : {::getuid(), ::geteuid()}) {
    if (const passwd* const entry = ::getpwuid(user)) {
      add_user(words, entry->pw_name);
      add_home(words, entry->pw_dir);
    }
  }
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0) add_host(words, host.data());
  for (const char* name : {"HOSTNAME", "HOST"}) add_host(words, facts.variable(name));
  add_display(words, facts.variable("DISPLAY"));
  for (const PortFacts& port : facts.ports)
    add_address(words, std::string_view(port.option).substr(port.option.find(' ') + 1));
  const auto is_longer = [](const std::string& a, const std::string& b) { return a.size() > b.size(); };
  std::stable_sort(words.homes.begin(), words.homes.end(), is_longer);
  return words;
}

std::string redacted(std::string text, const PrivateWords& words) {
  for (const std::string& home : words.homes) replace_home(text, home);
  replace_other_homes(text);
  replace_addresses(text);
  return replace_names(text, names_by_length(words));
}

}  // namespace fire3dv::doctor

#include "renderer/doctor/report/redaction.h"

#include <arpa/inet.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "base/text.h"
#include "base/words.h"

namespace fire3dv::doctor {
namespace {

bool is_alphanumeric(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}
bool is_word_character(char c) {
  return is_alphanumeric(c) || c == '_' || c == '-' || c == '.';
}

// Replaces a word, in any letter case, where it stands alone. in_names: also as a part of longer names: "ada"
// in "ada-2", "lab" in "lab.example.org".
void replace_words(std::string& text, const std::string& word, std::string_view by, bool in_names) {
  const auto belongs = [&](char c) { return in_names ? is_alphanumeric(c) : is_word_character(c); };
  if (word.empty()) return;
  const std::string lower_word = lower_case(word);
  std::string lower = lower_case(text);
  for (size_t at = lower.find(lower_word); at != std::string::npos; at = lower.find(lower_word, at)) {
    const bool begins = at == 0 || !belongs(text[at - 1]);
    const bool ends = at + word.size() == text.size() || !belongs(text[at + word.size()]);
    if (begins && ends) {
      text.replace(at, word.size(), by);
      lower.replace(at, word.size(), by);
    }
    at += begins && ends ? by.size() : word.size();
  }
}

bool is_ip_address(const std::string& text) {
  in_addr four{};
  in6_addr six{};
  return ::inet_pton(AF_INET, text.c_str(), &four) == 1 || ::inet_pton(AF_INET6, text.c_str(), &six) == 1;
}

bool names_this_machine(std::string_view address) {
  return address.starts_with("127.") || address == "0.0.0.0" || address == "::1" || address == "::";
}

// Runs of the characters of addresses that are one. A port may follow one of version 4.
void replace_ip_addresses(std::string& text) {
  constexpr std::string_view kFour = "0123456789.", kSix = "0123456789abcdefABCDEF:.";
  for (const std::string_view characters : {kSix, kFour}) {
    for (size_t at = text.find_first_of(characters); at != std::string::npos;
         at = text.find_first_of(characters, at)) {
      const size_t end = std::min(text.find_first_not_of(characters, at), text.size());
      std::string address = text.substr(at, end - at);
      while (address.ends_with('.')) address.pop_back();  // of a sentence
      const bool alone =
          (at == 0 || (!is_word_character(text[at - 1]) && (characters == kFour || text[at - 1] != '/'))) &&
          (end == text.size() || !is_word_character(text[end]));
      if (alone && is_ip_address(address) && !names_this_machine(address)) {
        text.replace(at, address.size(), "IP");
        at += 2;
      } else {
        at = end;
      }
    }
  }
}

void add(std::vector<std::string>& list, const std::string& word) {
  if (!word.empty() && word != "/" && std::find(list.begin(), list.end(), word) == list.end())
    list.push_back(word);
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
  const std::string lower = lower_case(name);
  if (lower == "localhost" || is_ip_address(name)) return;
  add(words.hosts, name);
  add(words.hosts, name.substr(0, name.find('.')));
}

// The host of "--listen tcp://HOST:PORT" and "--serve HOST:PORT".
std::string host_of_option(const std::string& option) {
  const size_t scheme = option.find("://"), blank = option.find(' ');
  if (option.find("shm://") != std::string::npos || blank == std::string::npos) return "";
  const size_t begin = scheme == std::string::npos ? blank + 1 : scheme + 3;
  const size_t colon = option.rfind(':');
  if (colon == std::string::npos || colon < begin) return "";
  return std::string(trimmed(option.substr(begin, colon - begin), "[]"));
}

}  // namespace

PrivateWords private_words(const Facts& facts) {
  PrivateWords words;
  add_home(words, facts.variable("HOME"));
  for (const char* name : {"USER", "LOGNAME", "SUDO_USER", "USERNAME"})
    add(words.users, facts.variable(name));
  for (const uid_t user : {::getuid(), ::geteuid()}) {
    if (const passwd* const entry = ::getpwuid(user)) {
      add(words.users, entry->pw_name);
      add_home(words, entry->pw_dir);
    }
  }
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0) add_host(words, host.data());
  for (const char* name : {"HOSTNAME", "HOST"}) add_host(words, facts.variable(name));
  const std::string display = facts.variable("DISPLAY");  // HOST:NUMBER
  if (display.find('/') == std::string::npos && display.rfind(':') != std::string::npos)
    add_host(words, display.substr(0, display.rfind(':')));
  for (const PortFacts& port : facts.ports) add_host(words, host_of_option(port.option));
  // Names that many users and machines have, and that other texts need.
  constexpr std::array kCommon{"root",   "user",  "nobody", "debian", "ubuntu",
                               "fedora", "linux", "unix",   "fire3dv"};
  for (std::vector<std::string>* list : {&words.users, &words.hosts})
    std::erase_if(*list, [&](const std::string& word) {
      return std::find(kCommon.begin(), kCommon.end(), lower_case(word)) != kCommon.end();
    });
  // The longest first: "lab.example.org" before "lab".
  const auto is_longer = [](const std::string& a, const std::string& b) { return a.size() > b.size(); };
  for (std::vector<std::string>* list : {&words.homes, &words.users, &words.hosts})
    std::stable_sort(list->begin(), list->end(), is_longer);
  return words;
}

std::string redacted(std::string text, const PrivateWords& words) {
  for (const std::string& home : words.homes) replace_words(text, home, "~", false);
  // Folders of other users, in whole.
  for (size_t at = text.find("/home/"); at != std::string::npos; at = text.find("/home/", at + 1)) {
    const size_t begin = at + std::string_view("/home/").size();
    size_t end = begin;
    while (end < text.size() && std::string_view("/:;,\"' \n)").find(text[end]) == std::string_view::npos)
      ++end;
    text.replace(begin, end - begin, "USER");
  }
  for (const std::string& user : words.users) replace_words(text, user, "USER", true);
  for (const std::string& host : words.hosts) replace_words(text, host, "HOST", true);
  replace_ip_addresses(text);
  return text;
}

}  // namespace fire3dv::doctor

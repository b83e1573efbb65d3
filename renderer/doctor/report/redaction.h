// Redaction of a report for an issue: names of users and hosts, home folders and IP addresses are replaced.
#pragma once

#include <string>
#include <vector>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

// Words that name the user and machines: of the system, of the environment, and of the options' addresses.
struct PrivateWords {
  std::vector<std::string> homes, users, hosts;
};
PrivateWords private_words(const Facts& facts);

// Replaces folders of users by "~", names of users by "USER", names of hosts with their domains by "HOST", in
// any letter case, and IP addresses by "IP". Hosts of URIs need not be known. Loopback addresses, those of
// all interfaces, and names that many have ("root", "nvidia") stay.
std::string redacted(std::string text, const PrivateWords& words);

}  // namespace fire3dv::doctor

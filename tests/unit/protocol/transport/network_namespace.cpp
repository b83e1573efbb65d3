// Network namespace with a veth pair, set up through ip(8); otherwise any multicast interface.
#include "tests/unit/protocol/transport/network_namespace.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>

#include <cstdlib>
#include <memory>

namespace fire3dv::transport::test {
namespace {

std::string& chosen() {
  static std::string name;
  return name;
}

bool enter_namespace() {
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  const std::string commands =
      "ip link set lo up && ip link add f3d0 type veth peer name f3d1 && ip link set f3d0 up && ip link set "
      "f3d1 up && "
      "ip -6 address add " +
      std::string(OwnNetwork::kLinkLocal) + "/64 dev f3d0 nodad";
  return std::system(commands.c_str()) == 0;
}

std::string any_multicast_interface() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> keep(list, &::freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    const bool has_v6 = entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_INET6;
    if (has_v6 && (entry->ifa_flags & IFF_MULTICAST) != 0 && (entry->ifa_flags & IFF_UP) != 0)
      return entry->ifa_name;
  }
  return {};
}

[[maybe_unused]] const auto* const kRegistered = testing::AddGlobalTestEnvironment(new OwnNetwork);

}  // namespace

void OwnNetwork::SetUp() {
  chosen() = enter_namespace() ? "f3d0" : any_multicast_interface();
  if (chosen().empty())
    GTEST_SKIP() << "neither a namespace with a network of its own nor an interface with IPv6";
}

const std::string& OwnNetwork::interface() {
  return chosen();
}

}  // namespace fire3dv::transport::test

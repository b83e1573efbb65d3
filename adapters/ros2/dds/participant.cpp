#include "adapters/ros2/dds/participant.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "adapters/ros2/dds/topics.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr uint32_t kMaxDomain = 232;  // greater ones have ports beyond 65535
constexpr size_t kMaxPeers = 64;

std::string xml_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

std::string text_of(const GetEnv& get_env, const char* name) {
  const char* const value = get_env(name);
  return value ? value : "";
}

Result<uint32_t> parse_domain(const std::string& text) {
  uint32_t id = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc() || rest != end || id > kMaxDomain)
    return Error{"ROS_DOMAIN_ID=" + quote(text) + " is not a number from 0 to 232"};
  return id;
}

Result<DiscoveryRange> parse_range(const std::string& text) {
  if (text.empty() || text == "SUBNET" || text == "SYSTEM_DEFAULT") return DiscoveryRange::subnet;
  if (text == "LOCALHOST") return DiscoveryRange::localhost;
  if (text == "OFF") return DiscoveryRange::off;
  return Error{"ROS_AUTOMATIC_DISCOVERY_RANGE=" + quote(text) + " is none of SUBNET, LOCALHOST, OFF"};
}

const char* range_text(DiscoveryRange range) {
  switch (range) {
    case DiscoveryRange::subnet:
      return "subnet";
    case DiscoveryRange::localhost:
      return "this machine (ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST)";
    case DiscoveryRange::loopback_only:
      return "loopback (ROS_LOCALHOST_ONLY=1)";
    case DiscoveryRange::off:
      break;
  }
  return "off (ROS_AUTOMATIC_DISCOVERY_RANGE=OFF)";
}

std::string interfaces_text() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return "unknown";
  std::string text;
  for (const ifaddrs* i = list; i; i = i->ifa_next) {
    if (!i->ifa_addr || i->ifa_addr->sa_family != AF_INET || !(i->ifa_flags & IFF_UP)) continue;
    char address[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr, address, sizeof address);
    text += (text.empty() ? "" : ", ") + std::string(i->ifa_name) + " " + address;
  }
  freeifaddrs(list);
  return text.empty() ? "none is up" : text;
}

// True if CYCLONEDDS_URI chooses the interfaces. It may also be a file, whose text only Cyclone DDS reads.
bool names_interfaces(const DomainSettings& settings) {
  return settings.cyclonedds_uri.find("NetworkInterface") != std::string::npos;
}

std::string used_interfaces_text(const DomainSettings& settings) {
  if (names_interfaces(settings)) return "of CYCLONEDDS_URI";
  if (settings.range == DiscoveryRange::loopback_only) return "lo";
  return interfaces_text() + (settings.cyclonedds_uri.empty() ? "" : ", or those of CYCLONEDDS_URI");
}

}  // namespace

std::string dds_text(dds_return_t code) {
  return std::string("DDS: ") + dds_strretcode(code);
}

Result<DomainSettings> domain_settings(const GetEnv& get_env, std::optional<uint32_t> domain_id) {
  DomainSettings settings;
  if (const std::string text = text_of(get_env, "ROS_DOMAIN_ID"); domain_id) {
    settings.domain_id = *domain_id;
    if (*domain_id > kMaxDomain) return Error{"domains are 0 to 232, not " + std::to_string(*domain_id)};
  } else if (!text.empty()) {
    const Result<uint32_t> id = parse_domain(text);
    if (!id) return id.error();
    settings.domain_id = *id;
  }
  const Result<DiscoveryRange> range = parse_range(text_of(get_env, "ROS_AUTOMATIC_DISCOVERY_RANGE"));
  if (!range) return range.error();
  settings.range = *range;
  const std::string only = text_of(get_env, "ROS_LOCALHOST_ONLY");
  if (only == "1")
    settings.range = DiscoveryRange::loopback_only;
  else if (!only.empty() && only != "0")
    return Error{"ROS_LOCALHOST_ONLY=" + quote(only) + " is not 0 or 1"};
  std::string peers = text_of(get_env, "ROS_STATIC_PEERS");
  for (size_t begin = 0; begin < peers.size();) {
    const size_t end = std::min(peers.find(';', begin), peers.size());
    if (end > begin) settings.static_peers.push_back(peers.substr(begin, end - begin));
    begin = end + 1;
  }
  if (settings.static_peers.size() > kMaxPeers) return Error{"ROS_STATIC_PEERS has more than 64 peers"};
  settings.cyclonedds_uri = text_of(get_env, "CYCLONEDDS_URI");
  return settings;
}

// "auto" indices and the peer localhost find participants that use no multicast; multicast stays on for those
// that announce themselves nowhere else. Naming two interfaces would turn multicast off. A short interval of
// announcements finds those that start later and announce themselves by multicast where there is none.
std::string cyclonedds_configuration(const DomainSettings& settings) {
  std::string general = "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>64000B</FragmentSize>";
  std::string discovery =
      "<ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
      "<SPDPInterval>2s</SPDPInterval>";
  std::string peers = "<Peer Address=\"localhost\"/>";
  for (const std::string& peer : settings.static_peers) peers += "<Peer Address=\"" + xml_text(peer) + "\"/>";
  switch (settings.range) {
    case DiscoveryRange::subnet:
      break;
    case DiscoveryRange::localhost:
      general += "<AllowMulticast>false</AllowMulticast>";
      break;
    case DiscoveryRange::loopback_only:
      // Cyclone DDS refuses an interface that is named twice.
      if (!names_interfaces(settings)) general += "<Interfaces><NetworkInterface name=\"lo\"/></Interfaces>";
      break;
    case DiscoveryRange::off:
      general += "<AllowMulticast>false</AllowMulticast>";
      discovery += "<Tag>ros_discovery_off_" + std::to_string(getpid()) + "</Tag>";
      peers.clear();
      break;
  }
  if (!peers.empty()) discovery += "<Peers>" + peers + "</Peers>";
  return "<CycloneDDS><Domain Id=\"any\"><General>" + general + "</General><Discovery>" + discovery +
         "</Discovery><Internal><SocketReceiveBufferSize min=\"default\" max=\"10MB\"/></Internal></Domain>"
         "</CycloneDDS>";
}

std::string domain_text(const DomainSettings& settings) {
  return "domain " + std::to_string(settings.domain_id) + ", range " + range_text(settings.range) +
         ", interfaces " + used_interfaces_text(settings);
}

Result<std::unique_ptr<Participant>> Participant::open(DomainSettings settings) {
  std::string configuration = cyclonedds_configuration(settings);
  if (!settings.cyclonedds_uri.empty()) configuration += "," + settings.cyclonedds_uri;
  const std::string id = std::to_string(settings.domain_id);
  Entity domain(dds_create_domain(settings.domain_id, configuration.c_str()));
  if (!domain) {
    const std::string hint = settings.cyclonedds_uri.empty() ? "" : "; check CYCLONEDDS_URI";
    return Error{"domain " + id + " cannot be opened (" + dds_text(domain.get()) + ")" + hint};
  }
  const UniqueQos qos(dds_create_qos());
  constexpr std::string_view kEnclave = "enclave=/;";
  dds_qset_userdata(qos.get(), kEnclave.data(), kEnclave.size());
  Entity participant(dds_create_participant(settings.domain_id, qos.get(), nullptr));
  if (!participant)
    return Error{"no participant in domain " + id + " (" + dds_text(participant.get()) +
                 "): is a network interface up, and are ports from " +
                 std::to_string(7400 + 250 * settings.domain_id) + " on free?"};
  return std::unique_ptr<Participant>(
      new Participant(std::move(settings), std::move(domain), std::move(participant)));
}

}  // namespace fire3dv::ros2

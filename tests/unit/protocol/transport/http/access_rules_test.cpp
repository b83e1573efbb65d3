// Access rules of HTTP servers: Host and Origin headers, and the options that allow more of them.
#include "protocol/transport/http/access_rules.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fire3dv::transport::http {
namespace {

AccessRules rules(const std::vector<std::string>& hosts = {}, const std::vector<std::string>& origins = {}) {
  Result<AllowedSites> sites = parse_allowed_sites(hosts, origins);
  EXPECT_TRUE(sites.ok()) << sites.error().message;
  return {.own_host = "robot.example", .options = {.sites = sites.ok() ? *sites : AllowedSites()}};
}

TEST(AccessRules, HostsOfOtherNamesAreRefused) {
  const AccessRules strict = rules();
  for (const char* good : {"127.0.0.1:8080", "localhost:9", "LocalHost", "[::1]:8080", "192.168.1.2:80",
                           "robot.example:8080", "ROBOT.example"})
    EXPECT_TRUE(strict.allows_host(good)) << good;
  for (const char* bad : {"", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example", "[::1",
                          "[::1]x", "localhost:80x", "localhost:80:80", ":8080"})
    EXPECT_FALSE(strict.allows_host(bad)) << bad;
  AccessRules secure = strict;
  secure.has_tls = true;
  EXPECT_TRUE(secure.allows_host("any.example:8080"));
  EXPECT_FALSE(secure.allows_host(""));
}

TEST(AccessRules, ProgramsNeedNoHostField) {
  AccessRules programs = rules();
  programs.clients = AccessRules::Clients::programs;
  EXPECT_TRUE(programs.allows_host(""));
  EXPECT_FALSE(programs.allows_host("evil.example"));
  programs.is_public = true;
  EXPECT_TRUE(programs.allows_host("renderer.example:9464"));
  EXPECT_FALSE(programs.allows_origin("http://evil.example", "127.0.0.1:9464"));
}

TEST(AccessRules, OriginIsTheServerItself) {
  const AccessRules strict = rules();
  EXPECT_TRUE(strict.allows_origin("http://127.0.0.1:8080", "127.0.0.1:8080"));
  EXPECT_TRUE(strict.allows_origin("http://[::1]:8080", "[::1]:8080"));
  EXPECT_TRUE(strict.allows_origin("http://robot.example", "robot.example:80"));
  for (const char* bad : {"", "null", "http://127.0.0.1:8081", "https://127.0.0.1:8080",
                          "http://127.0.0.1:8080/", "http://evil.example", "127.0.0.1:8080", "http://"})
    EXPECT_FALSE(strict.allows_origin(bad, "127.0.0.1:8080")) << bad;
  AccessRules secure = strict;
  secure.has_tls = true;
  EXPECT_TRUE(secure.allows_origin("https://Host:1", "host:1"));
  EXPECT_FALSE(secure.allows_origin("http://host:1", "host:1"));
}

TEST(AccessRules, AllowedOriginsMatchExactly) {
  const AccessRules allowed = rules({}, {"https://Sim.example/", "https://lab.example:8443"});
  for (const char* host : {"127.0.0.1:8080", "sim.example", "sim.example:8080", "lab.example"})
    EXPECT_TRUE(allowed.allows_host(host)) << host;
  EXPECT_FALSE(allowed.allows_host("example"));
  for (const char* good : {"https://sim.example", "https://SIM.example:443", "https://lab.example:8443"})
    EXPECT_TRUE(allowed.allows_origin(good, "127.0.0.1:8080")) << good;
  for (const char* bad : {"http://sim.example", "https://sim.example:8443", "https://lab.example",
                          "https://sim.example.evil.example", "https://evil.example", "https://a.sim.example",
                          "https://sim.example@evil.example", "null", ""})
    EXPECT_FALSE(allowed.allows_origin(bad, "127.0.0.1:8080")) << bad;
}

TEST(AccessRules, AllowedHostsAreExact) {
  const AccessRules allowed = rules({"Sim.example"});
  EXPECT_TRUE(allowed.allows_host("sim.example:8080"));
  EXPECT_TRUE(allowed.allows_origin("http://sim.example:8080", "sim.example:8080"));
  EXPECT_FALSE(allowed.allows_origin("https://sim.example", "sim.example"));
  for (const char* bad : {"a.sim.example", "sim.example.evil.example", "example", "evil.example"})
    EXPECT_FALSE(allowed.allows_host(bad)) << bad;
}

TEST(AccessRules, BadOptionsSayTheRightForm) {
  const auto error_of = [](const std::vector<std::string>& hosts, const std::vector<std::string>& origins) {
    const Result<AllowedSites> sites = parse_allowed_sites(hosts, origins);
    return sites.ok() ? std::string("none") : sites.error().message;
  };
  EXPECT_EQ(error_of({}, {"https://sim.example/sim1"}),
            "--allow-origin \"https://sim.example/sim1\": an origin has no path; write --allow-origin "
            "https://sim.example");
  for (const char* bad :
       {"", "*", "null", "sim.example", "https://*.example", "ftp://sim.example", "https://", "https://a:b",
        "https://sim.example:", "https://user@sim.example", "https://a b", "https://::1"})
    EXPECT_NE(error_of({}, {bad}).find("such as https://sim.example"), std::string::npos)
        << error_of({}, {bad});
  EXPECT_EQ(error_of({"https://sim.example"}, {}),
            "--allow-host \"https://sim.example\": is an origin; write --allow-origin https://sim.example");
  for (const char* bad : {"", "*", "*.example", "sim.example:80", "sim.example/a", ".example", "a b"})
    EXPECT_NE(error_of({bad}, {}).find("such as sim.example"), std::string::npos) << error_of({bad}, {});
}

TEST(AccessRules, RefusalsNameTheOption) {
  EXPECT_EQ(host_refusal("Sim.example:80"),
            "the Host header \"Sim.example:80\" is not allowed; start with --allow-host sim.example");
  EXPECT_EQ(host_refusal("a b"), "the Host header \"a b\" is not allowed");
  EXPECT_EQ(origin_refusal("https://Sim.example"),
            "origin https://sim.example is not allowed; start with --allow-origin https://sim.example");
  EXPECT_EQ(origin_refusal("null"), "origin \"null\" cannot be allowed: it has no host");
  EXPECT_EQ(origin_refusal("https://a;rm\x1b[2J"),
            "origin \"https://a;rm?[2J\" cannot be allowed: it has no host");
}

}  // namespace
}  // namespace fire3dv::transport::http

// Tests of the doctor's report as text, JSON and Markdown.
#include "renderer/doctor/report/report.h"

#include <gtest/gtest.h>

#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(Report, TextHasDevicesFindingsAndASummary) {
  Facts facts = good_machine();
  const std::string good = report_text(facts, run_checks(facts));
  EXPECT_TRUE(mentions(good, "0         0      0000:3b:00.0  01020304-0506-0708-090a-0b0c0d0e0f10  Big GPU"))
      << good;
  EXPECT_TRUE(mentions(good, "all is well"));
  facts.devices[0].read_back = {Outcome::hung, ""};
  const std::string bad = report_text(facts, run_checks(facts));
  EXPECT_TRUE(mentions(bad, "error    read-back")) << bad;
  EXPECT_TRUE(mentions(bad, "type: fire3dv --device 1 FILE"));
  EXPECT_TRUE(mentions(bad, "1 error, 0 warnings"));
}

TEST(Report, ControlCharactersDoNotReachTheTerminal) {
  Facts facts = good_machine();
  facts.devices[0].name = "GPU\x1b[2J";
  EXPECT_FALSE(mentions(report_text(facts, run_checks(facts)), "\x1b"));
}

TEST(Report, JsonHasStableMembers) {
  const Facts facts = good_machine();
  const nlohmann::json json = report_json(facts, run_checks(facts));
  EXPECT_EQ(json.at("exit_status"), 0);
  EXPECT_EQ(json.at("devices").at(0).at("pci_address"), "0000:3b:00.0");
  EXPECT_EQ(json.at("devices").at(0).at("read_back"), true);
  EXPECT_EQ(json.at("findings").at(0).at("id"), "loader");
  EXPECT_EQ(json.at("findings").at(0).at("level"), "ok");
}

TEST(Report, TheFileHasKnownVariablesAlone) {
  Facts facts = good_machine();
  facts.environment["VK_DRIVER_FILES"] = "/home/ada/lvp.json";
  facts.environment["NVIDIA_DRIVER_CAPABILITIES"] = "compute,utility";
  for (const char* secret : {"NVIDIA_API_KEY", "CUDA_TOKEN", "FIRE3DV_PASSWORD", "XDG_SECRET", "VK_KEY"})
    facts.environment[secret] = "nvapi-1234";
  facts.environment["XDG_CACHE_HOME"] = "https://key@example.org/cache";
  facts.environment["MESA_VK_DEVICE_SELECT"] = "{\"token\": 5}";
  const std::string text = report_file(facts, run_checks(facts));
  EXPECT_TRUE(mentions(text, "VK_DRIVER_FILES=~/lvp.json\n")) << text;
  EXPECT_TRUE(mentions(text, "NVIDIA_DRIVER_CAPABILITIES=compute,utility\n"));
  EXPECT_TRUE(mentions(text, "XDG_CACHE_HOME=(29 bytes, not shown)\n")) << text;
  for (const char* hidden :
       {"nvapi", "NVIDIA_API_KEY", "TOKEN", "token", "PASSWORD", "SECRET", "VK_KEY", "key@"})
    EXPECT_FALSE(mentions(text, hidden)) << hidden << text;
}

TEST(Report, FindingsDoNotShowHiddenValues) {
  Facts facts = good_machine();
  const std::string secret = "nvapi-1234 'it is secret'", long_secret(300, 'k');
  facts.environment["FIRE3DV_DEVICE_MASK"] = "{\"token\": \"" + secret + "\"}";
  facts.environment["VK_DRIVER_FILES"] = long_secret + ":/lvp.json";
  facts.manifests[0] = {long_secret, "VK_DRIVER_FILES", "", "it does not exist", {}};
  facts.loader.version = make_version(1, 3, 204);
  const std::vector<CheckedFinding> findings = run_checks(facts);
  ASSERT_TRUE(mentions(report_text(facts, findings), "nvapi-1234")) << "the terminal shows it";
  const std::string text = report_file(facts, findings);
  EXPECT_FALSE(mentions(text, "nvapi") || mentions(text, "it is secret") || mentions(text, "kkk")) << text;
  EXPECT_TRUE(mentions(text, "hides features of all devices: \"(not shown)\"")) << text;
}

TEST(Report, NamesDoNotEndTheBlockOfTheFile) {
  Facts facts = good_machine();
  facts.devices[0].name = "GPU\n````\n# title";
  facts.environment["TMPDIR"] = "/tmp/\n```";
  const std::string text = report_file(facts, run_checks(facts));
  const size_t begin = text.find("`````\n");
  ASSERT_NE(begin, std::string::npos) << text;
  EXPECT_EQ(text.find("\n`", begin + 1), text.size() - 7) << text;
  EXPECT_TRUE(mentions(text, "GPU?````?# title"));
}

}  // namespace
}  // namespace fire3dv::doctor

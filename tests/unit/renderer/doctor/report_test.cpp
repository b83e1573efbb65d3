// Tests of the doctor's report.
#include "renderer/doctor/report.h"

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

TEST(Report, NamesOfUsersAndHostsAreReplaced) {
  const PrivateWords words{{"/home/ada", "/data/ada"}, {"ada"}, {"lab-7"}};
  EXPECT_EQ(redacted("/home/ada/.cache, /data/ada/x, /home/bob/y, /srv/ada/z", words),
            "~/.cache, ~/x, /home/USER/y, /srv/USER/z");
  EXPECT_EQ(redacted("ada@lab-7 in adapter of lab-70", words), "USER@HOST in adapter of lab-70");
  EXPECT_EQ(redacted("/tmp/ada_2/x, lab-7.example.org:0, /home/bob@corp.org/y", words),
            "/tmp/USER_2/x, HOST.example.org:0, /home/USER/y");
}

TEST(Report, AHomeWithASlashAtItsEndIsReplaced) {
  Facts facts = good_machine();
  facts.environment["HOME"] = "/data/groups/ada/";
  EXPECT_EQ(redacted("/data/groups/ada/.cache", private_words(facts)), "~/.cache");
}

TEST(Report, TheFileHasTheVariablesThatMatter) {
  Facts facts = good_machine();
  facts.environment["VK_DRIVER_FILES"] = "/home/ada/lvp.json";
  facts.environment["SECRET_TOKEN"] = "x";
  const std::string text = redacted(report_file(facts, run_checks(facts)), {{"/home/ada"}, {"ada"}, {}});
  EXPECT_TRUE(mentions(text, "VK_DRIVER_FILES=~/lvp.json")) << text;
  EXPECT_FALSE(mentions(text, "SECRET_TOKEN"));
  EXPECT_FALSE(mentions(text, "ada"));
}

}  // namespace
}  // namespace fire3dv::doctor

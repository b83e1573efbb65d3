// Tests of what a report for an issue hides.
#include "renderer/doctor/report/redaction.h"

#include <gtest/gtest.h>

#include "base/text.h"
#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(Redaction, NamesOfUsersAndHostsAreReplaced) {
  const PrivateWords words{{"/home/ada", "/data/ada"}, {"ada"}, {"lab-7"}};
  EXPECT_EQ(redacted("/home/ada/.cache, /data/ada/x, /home/bob/y, /srv/ada/z", words),
            "~/.cache, ~/x, /home/USER/y, /srv/USER/z");
  EXPECT_EQ(redacted("ada@lab-7 in adapter of lab-70", words), "USER@HOST in adapter of lab-70");
  EXPECT_EQ(redacted("/tmp/ada_2/x, lab-7.example.org:0, /home/bob@corp.org/y", words),
            "/tmp/USER_2/x, HOST:0, /home/USER/y");
}

TEST(Redaction, LongNamesComeBeforeTheirParts) {
  const PrivateWords words{{}, {"ada"}, {"ada-thinkpad", "user"}};
  EXPECT_EQ(redacted("ada on ada-thinkpad.lab.example.org.", words), "USER on HOST.");
  EXPECT_EQ(redacted("ada and user", words), "USER and HOST") << "what stands for a name is no name";
}

TEST(Redaction, LetterCaseDoesNotMatter) {
  const PrivateWords words{{"/home/ada"}, {"ada"}, {"Lab-7.Example.org", "Lab-7"}};
  EXPECT_EQ(redacted("LAB-7.example.ORG lab-7 /srv/Ada Adapter", words), "HOST HOST /srv/USER Adapter");
}

TEST(Redaction, AddressesAreReplaced) {
  EXPECT_EQ(redacted("tcp://10.1.2.3:7345, udp://[2001:db8::1]:7346, fe80::1%eth0, at 192.168.1.4.", {}),
            "tcp://IP:7345, udp://[IP]:7346, IP%eth0, at IP.");
  EXPECT_EQ(redacted("--serve 2001:db8::1:80, DISPLAY=2001:db8::7:0.0 tcp://2001:db8::1 fe80::1.", {}),
            "--serve IP, DISPLAY=IP.0 tcp://IP IP.");
  const std::string kept =
      "127.0.0.1:80 0.0.0.0 [::1]:80 1.3.239 Mesa 25.0.7 0000:3b:00.0 /a::/b 5.15.153.1-microsoft "
      "/c/bead::/x "
      "01020304-0506-0708-090a-0b0c0d0e0f10";
  EXPECT_EQ(redacted(kept, {}), kept);
}

TEST(Redaction, HostsOfUrisNeedNotBeKnown) {
  EXPECT_EQ(redacted("tcp://render.example.net: no such host; udp://web-3, tls://ada:se/cr@t@box:7/path", {}),
            "tcp://HOST: no such host; udp://HOST, tls://USER@HOST:7/path");
  const std::string kept =
      "tcp://localhost:5000 tcp://127.0.0.1 tcp://[::1]:80 tcp://0.0.0.0:1 tcp://:5 shm://demo";
  EXPECT_EQ(redacted(kept, {}), kept);
}

// Each of these once stayed in a report.
TEST(Redaction, HostsOfOptionsNeedNoPort) {
  for (const char* option :
       {"--serve web-3", "--metrics web-3:", "--listen tcp://web-3", "--listen tcp://ada:hunter2@web-3:80"}) {
    Facts facts = good_machine();
    facts.ports = {{option, "web-3: unknown; hunter2", false}};
    const std::string text =
        redacted(facts.ports[0].option + " " + facts.ports[0].fault, private_words(facts));
    EXPECT_FALSE(mentions(text, "web-3")) << text;
    EXPECT_TRUE(!mentions(text, "hunter2") || !mentions(option, "hunter2")) << text;
  }
}

TEST(Redaction, HostsOfDisplaysAreReplaced) {
  for (const char* display : {"box7:0", "tcp/box7:0.0", "box7::0", "unix/box7:1"}) {
    Facts facts = good_machine();
    facts.environment["DISPLAY"] = display;
    const std::string text =
        redacted(std::string("DISPLAY=") + display + ", box7 port 6000", private_words(facts));
    EXPECT_FALSE(mentions(text, "box7")) << text;
  }
}

TEST(Redaction, UsersOfDomainsAreReplaced) {
  for (const char* user : {"CORP\\ada", "ada@corp.example.org", "ada@corp"}) {
    Facts facts = good_machine();
    facts.environment = {{"USER", user}};
    const std::string text = redacted(std::string(user) + " /srv/ada/x CORP", private_words(facts));
    EXPECT_FALSE(mentions(lower_case(text), "ada") || mentions(lower_case(text), "corp") ||
                 mentions(text, "example"))
        << text;
  }
  EXPECT_EQ(redacted("ada@corp.org", {{}, {"ada"}, {}}), "USER@HOST");
}

TEST(Redaction, WordsComeFromEnvironmentAndAddresses) {
  Facts facts = good_machine();
  facts.environment = {{"HOME", "/data/groups/ada/"},
                       {"USER", "ada"},
                       {"HOSTNAME", "box.example.org"},
                       {"DISPLAY", "thin-client:10.0"}};
  facts.ports = {{"--listen tcp://render.example.net:5000", "", false},
                 {"--serve web-3:80", "", false},
                 {"--listen shm://demo", "", false},
                 {"--metrics 127.0.0.1:9464", "", false}};
  const PrivateWords words = private_words(facts);
  EXPECT_EQ(redacted("/data/groups/ada/.cache ada@box", words), "~/.cache USER@HOST");
  EXPECT_EQ(redacted("DISPLAY=thin-client:10.0 tcp://render.example.net:5000 web-3:80 shm://demo", words),
            "DISPLAY=HOST:10.0 tcp://HOST:5000 HOST:80 shm://demo");
}

TEST(Redaction, CommonNamesStay) {
  Facts facts = good_machine();
  facts.environment = {{"USER", "ubuntu"}, {"HOSTNAME", "debian"}};
  EXPECT_EQ(redacted("Debian GNU/Linux, Ubuntu", private_words(facts)), "Debian GNU/Linux, Ubuntu");
  const std::string report =
      "error /dev/dri/renderD128: this user may not, which the group video may; libGLX_nvidia.so.0, a device";
  for (const char* user : {"nvidia", "dev", "root", "video", "a", "User"}) {
    facts.environment = {{"USER", user}, {"HOME", std::string("/home/") + user}, {"HOSTNAME", user}};
    EXPECT_EQ(redacted(report, private_words(facts)), report) << user;
    EXPECT_EQ(redacted(std::string("/home/") + user + "/x", private_words(facts)), "~/x");
  }
}

}  // namespace
}  // namespace fire3dv::doctor

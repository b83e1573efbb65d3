// Tests of what a report for an issue hides.
#include "renderer/doctor/report/redaction.h"

#include <gtest/gtest.h>

#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(Redaction, NamesOfUsersAndHostsAreReplaced) {
  const PrivateWords words{{"/home/ada", "/data/ada"}, {"ada"}, {"lab-7"}};
  EXPECT_EQ(redacted("/home/ada/.cache, /data/ada/x, /home/bob/y, /srv/ada/z", words),
            "~/.cache, ~/x, /home/USER/y, /srv/USER/z");
  EXPECT_EQ(redacted("ada@lab-7 in adapter of lab-70", words), "USER@HOST in adapter of lab-70");
  EXPECT_EQ(redacted("/tmp/ada_2/x, lab-7.example.org:0, /home/bob@corp.org/y", words),
            "/tmp/USER_2/x, HOST.example.org:0, /home/USER/y");
}

TEST(Redaction, LetterCaseDoesNotMatter) {
  const PrivateWords words{{"/home/ada"}, {"ada"}, {"Lab-7.Example.org", "Lab-7"}};
  EXPECT_EQ(redacted("LAB-7.example.ORG lab-7 /srv/Ada Adapter", words), "HOST HOST /srv/USER Adapter");
}

TEST(Redaction, AddressesAreReplaced) {
  EXPECT_EQ(redacted("tcp://10.1.2.3:7345, udp://[2001:db8::1]:7346, fe80::1%eth0, at 192.168.1.4.", {}),
            "tcp://IP:7345, udp://[IP]:7346, IP%eth0, at IP.");
  const std::string kept =
      "127.0.0.1:80 0.0.0.0 [::1]:80 1.3.239 Mesa 25.0.7 0000:3b:00.0 /a::/b 5.15.153.1-microsoft "
      "/c/bead::/x "
      "01020304-0506-0708-090a-0b0c0d0e0f10";
  EXPECT_EQ(redacted(kept, {}), kept);
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
}

}  // namespace
}  // namespace fire3dv::doctor

// Tests of the checks of rights, shared memory, folders, display, limits and ports.
#include <gtest/gtest.h>

#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

TEST(SystemChecks, ANodeWithoutRightsNamesItsGroup) {
  Facts facts = good_machine();
  facts.render_nodes = {{"/dev/dri/renderD128", "render", false}};
  const Finding found = fault(facts, "device-nodes");
  EXPECT_EQ(found.level, Level::warning);
  EXPECT_TRUE(mentions(found.text, "/dev/dri/renderD128"));
  EXPECT_TRUE(mentions(found.fix, "sudo usermod -aG render $USER"));
  facts.render_nodes = {{"/dev/dri/renderD128", "render", false, 0600, 105}};
  EXPECT_EQ(fault(facts, "device-nodes").text,
            "this user may not read and write /dev/dri/renderD128: its mode is 0600");
  EXPECT_EQ(fault(facts, "device-nodes").fix, "sudo chmod g+rw /dev/dri/renderD128");
  facts.container = true;
  EXPECT_EQ(fault(facts, "device-nodes").fix,
            "docker run --device /dev/dri/renderD128 --group-add 105 IMAGE");
}

TEST(SystemChecks, AGpuWithoutANodeIsAWarning) {
  Facts facts = software_machine();
  facts.gpu_vendors = {"Intel"};
  EXPECT_TRUE(mentions(fault(facts, "device-nodes").text, "no device node /dev/dri"));
  facts.container = true;
  EXPECT_TRUE(mentions(fault(facts, "device-nodes").fix, "--device /dev/dri"));
}

TEST(SystemChecks, SharedMemoryThatIsMissingSmallOrFullIsAWarning) {
  Facts facts = good_machine();
  facts.container = true;
  facts.shared_memory = Facts::SharedMemory::missing;
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").text, "/dev/shm is missing"));
  facts.shared_memory = Facts::SharedMemory::not_writable;
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").text, "cannot be written"));
  facts.shared_memory = Facts::SharedMemory::read_only;
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").text, "/dev/shm is mounted read-only"));
  facts.shared_memory = Facts::SharedMemory::writable;
  facts.shared_memory_bytes = uint64_t{64} << 20;
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").text, "only 64 MiB"));
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").fix, "--shm-size=1g"));
  facts.shared_memory_bytes = uint64_t{1} << 30;
  facts.shared_memory_free_bytes = uint64_t{1} << 20;
  EXPECT_TRUE(mentions(fault(facts, "shared-memory").text, "almost full"));
}

TEST(SystemChecks, FoldersThatAreMissingAreNamed) {
  Facts facts = good_machine();
  facts.environment.erase("HOME");
  facts.cache_folder = "";
  EXPECT_EQ(fault(facts, "home").level, Level::note);
  EXPECT_TRUE(mentions(fault(facts, "cache").fix, "XDG_CACHE_HOME"));
  facts = good_machine();
  facts.cache_fault = "Read-only file system";
  EXPECT_TRUE(mentions(fault(facts, "cache").text, "cannot be written (Read-only file system)"));
}

TEST(SystemChecks, ADisplayThatIsMissingOrSilentIsNamed) {
  Facts facts = good_machine();
  facts.display_fault = "/tmp/.X11-unix/X0: Connection refused";
  EXPECT_EQ(fault(facts, "display").level, Level::warning);
  facts.display = facts.display_fault = "";
  EXPECT_TRUE(mentions(fault(facts, "display").fix, "--headless"));
}

TEST(SystemChecks, LowLimitsAreNamed) {
  Facts facts = good_machine();
  facts.open_files_limit = 40;
  facts.locked_memory_bytes = 0;
  EXPECT_TRUE(mentions(fault(facts, "open-files").text, "may open only 40 files"));
  EXPECT_EQ(fault(facts, "locked-memory").level, Level::note);
  facts.address_space_bytes = uint64_t{400} << 20;
  EXPECT_TRUE(mentions(fault(facts, "address-space").text, "only 400 MiB of address space"));
}

TEST(SystemChecks, APortInUseIsAnError) {
  Facts facts = good_machine();
  facts.ports = {{"--listen tcp://127.0.0.1:5000", "the port is in use", true}};
  EXPECT_EQ(ids(facts, Level::error), std::vector<std::string>{"ports"});
  EXPECT_EQ(fault(facts, "ports").fix, "ss -lntup");
}

}  // namespace
}  // namespace fire3dv::doctor

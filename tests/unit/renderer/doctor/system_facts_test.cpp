// Tests of facts that are read from files, with folders that stand for the machine's.
#include "renderer/doctor/system_facts.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "base/unique_fd.h"
#include "tests/unit/renderer/doctor/folders.h"
#include "tests/unit/renderer/doctor/machines.h"

namespace fire3dv::doctor {
namespace {

Facts facts_of(const TestRoot& root, std::map<std::string, std::string> environment = {}) {
  Facts facts;
  facts.environment = std::move(environment);
  gather_system_facts(facts, root.path());
  return facts;
}

TEST(SystemFacts, AnEmptyMachineHasNothing) {
  const TestRoot root;
  const Facts facts = facts_of(root);
  EXPECT_FALSE(facts.wsl || facts.container);
  EXPECT_EQ(facts.shared_memory, Facts::SharedMemory::missing);
  EXPECT_TRUE(facts.render_nodes.empty() && facts.nvidia_nodes.empty() && facts.display.empty());
  EXPECT_GT(facts.open_files_limit, 0u);
}

TEST(SystemFacts, WslIsRecognisedByItsKernel) {
  const TestRoot root;
  root.write("proc/version", "Linux version 5.15.153.1-microsoft-standard-WSL2 (root@x) (gcc) #1 SMP\n");
  EXPECT_TRUE(facts_of(root).wsl);
}

TEST(SystemFacts, ContainersAreRecognised) {
  const TestRoot root;
  root.write(".dockerenv", "");
  EXPECT_TRUE(facts_of(root).container);
  const TestRoot other;
  EXPECT_TRUE(facts_of(other, {{"KUBERNETES_SERVICE_HOST", "10.0.0.1"}}).container);
}

TEST(SystemFacts, NodesAndDriverOfNvidiaAreFound) {
  const TestRoot root;
  for (const char* node : {"nvidia0", "nvidia12", "nvidiactl", "nvidia-uvm", "nvidia-modeset"})
    root.write(std::string("dev/") + node, "");
  root.write("dev/dri/renderD128", "");
  root.write("dev/dri/card0", "");
  root.write(
      "proc/driver/nvidia/version",
      "NVRM version: NVIDIA UNIX x86_64 Kernel Module  580.65.06  Sun Jul 27 07:13:32 UTC 2025\nGCC 12\n");
  const Facts facts = facts_of(root);
  ASSERT_EQ(facts.nvidia_nodes.size(), 3u);
  EXPECT_EQ(facts.nvidia_nodes[0].path, "/dev/nvidia0");
  EXPECT_TRUE(facts.nvidia_nodes[0].accessible);
  ASSERT_EQ(facts.render_nodes.size(), 1u);
  EXPECT_EQ(facts.render_nodes[0].path, "/dev/dri/renderD128");
  EXPECT_EQ(facts.nvidia_driver, "580.65.06");
}

TEST(SystemFacts, TheGroupOfANodeIsNamed) {
  const TestRoot root;
  root.write("dev/dri/renderD128", "");
  root.write("etc/group", "root:x:0:\nours:x:" + std::to_string(::getegid()) + ":ada\n");
  const std::string group = facts_of(root).render_nodes.at(0).group;
  EXPECT_TRUE(group == "ours" || (::getegid() == 0 && group == "root")) << group;
}

TEST(SystemFacts, RightsAreThoseOfTheEffectiveUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root has another effective user";
  const TestRoot root;
  root.write("dev/dri/renderD128", "");
  for (const char* folder : {"", "dev", "dev/dri"}) ::chmod((root.path() / folder).c_str(), 0755);
  ::chmod((root.path() / "dev/dri/renderD128").c_str(), 0600);
  EXPECT_TRUE(facts_of(root).render_nodes.at(0).accessible);
  ASSERT_EQ(::seteuid(65534), 0);
  const Facts facts = facts_of(root);
  ASSERT_EQ(::seteuid(0), 0);
  ASSERT_EQ(facts.render_nodes.size(), 1u);
  EXPECT_FALSE(facts.render_nodes[0].accessible);
  EXPECT_FALSE(facts.render_nodes[0].group_may());
}

TEST(SystemFacts, DisplaysHaveHostAndNumber) {
  const TestRoot root;
  for (const char* wrong : {"garbage", "0", ":", ":x", ":0.", "host:1x", ":70000"})
    EXPECT_EQ(facts_of(root, {{"DISPLAY", wrong}}).display_fault,
              "DISPLAY is not of the form [HOST]:NUMBER[.SCREEN]")
        << wrong;
  const Facts remote = facts_of(root, {{"DISPLAY", "localhost:10.0"}});
  EXPECT_EQ(remote.display_host + std::to_string(remote.display_port), "localhost6010");
  EXPECT_EQ(remote.display_fault, "");
  EXPECT_TRUE(mentions(facts_of(root, {{"DISPLAY", "unix:4"}}).display_fault, ".X11-unix/X4"));
}

TEST(SystemFacts, ALoaderOfLdLibraryPathIsFound) {
  const TestRoot root;
  root.write("opt/b/libvulkan.so.1", "");
  root.write("opt/c/libvulkan.so.1", "");
  EXPECT_EQ(facts_of(root, {{"LD_LIBRARY_PATH", "/opt/a::/opt/b:/opt/c"}}).loader.override_file,
            "/opt/b/libvulkan.so.1");
  EXPECT_EQ(facts_of(root).loader.override_file, "");
}

TEST(SystemFacts, TheSystemIsNamed) {
  const TestRoot root;
  root.write("etc/os-release", "ID=debian\nPRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\nNAME=x\n");
  EXPECT_EQ(facts_of(root).system, "Debian GNU/Linux 12 (bookworm)");
}

TEST(SystemFacts, ACacheBelowAFileCannotBeWritten) {
  const TestRoot root;
  root.write("file", "");
  Facts facts;
  facts.cache_folder = root.path() / "file/fire3dv";
  gather_system_facts(facts, root.path());
  EXPECT_TRUE(mentions(facts.cache_fault, "is no folder"));
  facts.cache_folder = root.path() / "new/fire3dv";
  gather_system_facts(facts, root.path());
  EXPECT_EQ(facts.cache_fault, "");
}

TEST(SystemFacts, ADisplayIsAskedByItsSocket) {
  const TestRoot root;
  std::filesystem::create_directories(root.path() / "tmp/.X11-unix");
  EXPECT_NE(facts_of(root, {{"DISPLAY", ":7.0"}}).display_fault, "");
  const UniqueFd server(::socket(AF_UNIX, SOCK_STREAM, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = root.path() / "tmp/.X11-unix/X7";
  ASSERT_LT(name.size(), sizeof(address.sun_path));
  std::memcpy(address.sun_path, name.c_str(), name.size());
  ASSERT_EQ(::bind(server.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  ASSERT_EQ(::listen(server.get(), 1), 0);
  EXPECT_EQ(facts_of(root, {{"DISPLAY", ":7.0"}}).display_fault, "");
  // A Wayland display that does not answer, beside an X11 display that does: windows open.
  const Facts both = facts_of(root, {{"DISPLAY", ":7"}, {"WAYLAND_DISPLAY", "none"}});
  EXPECT_EQ(both.display, ":7");
  EXPECT_EQ(both.display_fault, "");
}

}  // namespace
}  // namespace fire3dv::doctor

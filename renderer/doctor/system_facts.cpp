#include "renderer/doctor/system_facts.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include "base/numbers.h"
#include "base/text.h"
#include "base/unique_fd.h"
#include "base/words.h"

extern char** environ;

namespace fire3dv::doctor {
namespace {

using std::filesystem::path;
constexpr uint16_t kX11Port = 6000;  // TCP port of display 0

// The first 4 KiB of a file: those of /proc and /sys have no size.
std::string beginning_of(const path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  std::string text(4096, '\0');
  const ssize_t count = fd ? ::read(fd.get(), text.data(), text.size()) : -1;
  text.resize(static_cast<size_t>(std::max<ssize_t>(count, 0)));
  return text;
}

std::string line_with(const std::string& text, std::string_view key) {
  const size_t begin = text.starts_with(key) ? 0 : text.find("\n" + std::string(key));
  if (begin == std::string::npos) return "";
  const size_t value = begin + (begin == 0 && text.starts_with(key) ? 0 : 1) + key.size();
  return text.substr(value, text.find('\n', value) - value);
}

// With the rights that opening the file has: those of the effective user. errno: why not.
bool may(const path& file, int mode) {
  return ::faccessat(AT_FDCWD, file.c_str(), mode, AT_EACCESS) == 0;
}

std::vector<path> entries_of(const path& folder, std::string_view prefix) {
  std::vector<path> entries;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    if (at->path().filename().string().starts_with(prefix)) entries.push_back(at->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

// From /etc/group: the system's lookup may ask the network.
std::string group_name(const path& root, gid_t group) {
  std::ifstream file(root / "etc/group");
  for (std::string line; std::getline(file, line);) {
    const size_t name_end = line.find(':'), password_end = line.find(':', name_end + 1);
    if (name_end == std::string::npos || password_end == std::string::npos) continue;
    if (line.substr(password_end + 1).starts_with(std::to_string(group) + ":"))
      return line.substr(0, name_end);
  }
  return "";
}

NodeFacts node_facts(const path& root, const path& node) {
  NodeFacts facts;
  facts.path = "/dev" / node.lexically_relative(root / "dev");
  struct stat status {};
  if (::stat(node.c_str(), &status) == 0) {
    facts.group = group_name(root, status.st_gid);
    facts.mode = status.st_mode & 0777;
    facts.gid = status.st_gid;
  }
  facts.accessible = may(node, R_OK | W_OK);
  return facts;
}

void gather_nodes(Facts& facts, const path& root) {
  for (const path& node : entries_of(root / "dev/dri", "renderD"))
    facts.render_nodes.push_back(node_facts(root, node));
  for (const path& node : entries_of(root / "dev", "nvidia")) {
    const std::string number = node.filename().string().substr(std::strlen("nvidia"));
    const bool is_gpu = !number.empty() && number.find_first_not_of("0123456789") == std::string::npos;
    if (is_gpu || number == "ctl") facts.nvidia_nodes.push_back(node_facts(root, node));
  }
  // "NVRM version: NVIDIA UNIX x86_64 Kernel Module  580.65.06  ..."
  const std::string version = beginning_of(root / "proc/driver/nvidia/version");
  std::string_view words = version;
  for (std::string_view word = next_word(words); !word.empty(); word = next_word(words)) {
    const size_t dot = word.find('.');
    if (dot == 3 && word.find_first_not_of("0123456789.") == std::string_view::npos) {
      facts.nvidia_driver = word;
      break;
    }
  }
}

void gather_identity(Facts& facts, const path& root) {
  const std::string kernel = lower_case(beginning_of(root / "proc/version"));
  std::error_code ignored;
  facts.wsl =
      kernel.find("microsoft") != std::string::npos || std::filesystem::exists(root / "dev/dxg", ignored);
  facts.container = std::filesystem::exists(root / ".dockerenv", ignored) ||
                    std::filesystem::exists(root / "run/.containerenv", ignored) ||
                    std::filesystem::exists(root / ".singularity.d", ignored) ||
                    !facts.variable("KUBERNETES_SERVICE_HOST").empty() ||
                    !facts.variable("container").empty();
  const std::string release = beginning_of(root / "etc/os-release");
  facts.system = printable_text(trimmed(line_with(release, "PRETTY_NAME="), "\""), 100);
}

void gather_shared_memory(Facts& facts, const path& root) {
  const path folder = root / "dev/shm";
  struct statvfs room {};
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    facts.shared_memory = Facts::SharedMemory::missing;
  } else if (!may(folder, W_OK | X_OK)) {
    facts.shared_memory = errno == EROFS ? Facts::SharedMemory::read_only : Facts::SharedMemory::not_writable;
  } else if (::statvfs(folder.c_str(), &room) == 0) {
    facts.shared_memory_bytes = uint64_t{room.f_blocks} * room.f_frsize;
    facts.shared_memory_free_bytes = uint64_t{room.f_bavail} * room.f_frsize;
  }
}

// Why files cannot be made in a folder, which may not exist yet.
std::string write_fault(path folder) {
  std::error_code ignored;
  while (!std::filesystem::exists(folder, ignored) && folder.has_relative_path())
    folder = folder.parent_path();
  if (!std::filesystem::is_directory(folder, ignored)) return folder.string() + " is no folder";
  return may(folder, W_OK | X_OK) ? "" : std::strerror(errno);
}

std::string connect_fault(const path& socket_file) {
  const UniqueFd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = socket_file.string();
  if (!fd || name.size() >= sizeof(address.sun_path)) return "its socket has no usable name";
  std::memcpy(address.sun_path, name.c_str(), name.size() + 1);
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0 ||
      errno == EAGAIN)
    return "";
  return name + ": " + std::strerror(errno);
}

// Of "[HOST]:NUMBER[.SCREEN]"; nothing: it has another form.
struct X11Display {
  std::string host;  // empty: a socket of this machine
  uint16_t number = 0;
};
std::optional<X11Display> parse_display(const std::string& text) {
  constexpr uint16_t kMaxNumber = UINT16_MAX - kX11Port;
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  const std::string rest = text.substr(colon + 1);
  const size_t dot = std::min(rest.find('.'), rest.size());
  const std::optional<uint16_t> number = parse_number<uint16_t>(rest.substr(0, dot));
  const bool has_screen = dot < rest.size();
  if (!number || *number > kMaxNumber || (has_screen && !parse_number<uint16_t>(rest.substr(dot + 1))))
    return std::nullopt;
  const std::string host(trimmed(std::string_view(text).substr(0, colon), "[]"));
  return X11Display{host == "unix" ? "" : host, *number};
}

void gather_display(Facts& facts, const path& root) {
  const std::string wayland = facts.variable("WAYLAND_DISPLAY"), x11 = facts.variable("DISPLAY");
  if (!wayland.empty()) {
    facts.display = wayland;
    const bool absolute = wayland.starts_with('/');
    facts.display_fault =
        connect_fault(absolute ? path(wayland) : path(facts.variable("XDG_RUNTIME_DIR")) / wayland);
    if (facts.display_fault.empty() || x11.empty()) return;
  }
  if (x11.empty()) return;
  facts.display = x11;
  facts.display_fault.clear();
  const std::optional<X11Display> display = parse_display(x11);
  if (!display) {
    facts.display_fault = "DISPLAY is not of the form [HOST]:NUMBER[.SCREEN]";
  } else if (display->host.empty()) {
    facts.display_fault = connect_fault(root / ("tmp/.X11-unix/X" + std::to_string(display->number)));
  } else {
    facts.display_host = display->host;
    facts.display_port = static_cast<uint16_t>(kX11Port + display->number);
  }
}

void gather_loader(Facts& facts, const path& root) {
  const std::string folders = facts.variable("LD_LIBRARY_PATH");
  for (size_t begin = 0; !folders.empty() && begin <= folders.size();) {
    const size_t end = std::min(folders.find_first_of(":;", begin), folders.size());
    const path file = path(folders.substr(begin, end - begin)) / "libvulkan.so.1";
    std::error_code ignored;
    if (std::filesystem::exists(file.is_absolute() ? root / file.relative_path() : file, ignored)) {
      facts.loader.override_file = file.string();
      return;
    }
    begin = end + 1;
  }
}

void gather_limits(Facts& facts) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0)
    facts.open_files_limit = limit.rlim_cur == RLIM_INFINITY ? UINT64_MAX : limit.rlim_cur;
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0)
    facts.locked_memory_bytes = limit.rlim_cur == RLIM_INFINITY ? UINT64_MAX : limit.rlim_cur;
  if (::getrlimit(RLIMIT_AS, &limit) == 0)
    facts.address_space_bytes = limit.rlim_cur == RLIM_INFINITY ? UINT64_MAX : limit.rlim_cur;
}

}  // namespace

std::map<std::string, std::string> environment_variables() {
  std::map<std::string, std::string> variables;
  for (char** at = environ; at && *at; ++at) {
    const std::string_view text = *at;
    const size_t equals = text.find('=');
    if (equals != std::string_view::npos)
      variables.emplace(std::string(text.substr(0, equals)), std::string(text.substr(equals + 1)));
  }
  return variables;
}

void gather_system_facts(Facts& facts, const path& root) {
  gather_identity(facts, root);
  gather_nodes(facts, root);
  gather_shared_memory(facts, root);
  if (!facts.cache_folder.empty()) facts.cache_fault = write_fault(facts.cache_folder);
  gather_display(facts, root);
  gather_loader(facts, root);
  gather_limits(facts);
}

}  // namespace fire3dv::doctor

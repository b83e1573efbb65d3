#include "renderer/app/drake_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

namespace fire3dv::app {

std::optional<std::vector<std::string>> drake_arguments(int argc, const char* const* argv) {
  constexpr std::string_view kOption = "--drake", kAssigned = "--drake=";
  std::vector<std::string> address, others;
  bool is_found = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word.starts_with(kAssigned)) {
      is_found = true;
      address.emplace_back(word.substr(kAssigned.size()));
    } else if (word == kOption) {
      is_found = true;
      if (i + 1 < argc) address.emplace_back(argv[++i]);
    } else {
      others.emplace_back(word);
    }
  }
  if (!is_found) return std::nullopt;
  address.insert(address.end(), others.begin(), others.end());
  return address;
}

Error execute_drake(const std::vector<std::string>& arguments) {
  std::error_code unknown;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (unknown) return Error{"--drake: cannot find fire3dv-drake: the path of fire3dv itself is unknown"};
  const std::string program = (own.parent_path() / "fire3dv-drake").string();
  std::vector<char*> words{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  ::execv(program.c_str(), words.data());
  return Error{"--drake: this installation has no render server for Drake: " + program + " (" +
               std::strerror(errno) + "); build it with libboost-dev, or install it there"};
}

}  // namespace fire3dv::app

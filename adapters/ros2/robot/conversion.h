// Conversion of a robot description (URDF text) to glTF by fire3dv-convert, a process of its own: the text
// comes from the network, and the libraries that read it and its meshes may crash.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::ros2 {

struct ConvertedRobot {
  std::vector<uint8_t> glb;
  std::vector<std::string> warnings;
};

// One running conversion. Its files lie in a private folder, which goes with it; so does the process.
class Conversion {
 public:
  // Runs the fire3dv-convert beside this program; neither PATH nor a shell is used. `topic` stands for the
  // file in messages.
  static Result<Conversion> start(const std::string& urdf, const std::vector<std::string>& package_folders,
                                  const std::string& topic);
  Conversion(Conversion&& other) noexcept;
  Conversion& operator=(Conversion&& other) noexcept;
  ~Conversion();

  // Nothing while it runs. Does not block.
  std::optional<Result<ConvertedRobot>> poll();

 private:
  explicit Conversion(std::filesystem::path folder, std::string topic)
      : folder_(std::move(folder)), topic_(std::move(topic)) {}
  Result<ConvertedRobot> finish(int status) const;
  std::string in_words(std::string text) const;  // with the topic in place of the file

  std::filesystem::path folder_;
  std::string topic_;
  pid_t child_ = 0;
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace fire3dv::ros2

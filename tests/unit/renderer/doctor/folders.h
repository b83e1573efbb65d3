// Folder that stands for "/" in tests.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace fire3dv::doctor {

class TestRoot {
 public:
  TestRoot() {
    std::string name = std::filesystem::temp_directory_path() / "fire3dv-doctor-XXXXXX";
    root_ = ::mkdtemp(name.data());
  }
  ~TestRoot() { std::filesystem::remove_all(root_); }
  TestRoot(const TestRoot&) = delete;
  TestRoot& operator=(const TestRoot&) = delete;

  const std::filesystem::path& path() const { return root_; }
  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text;
  }

 private:
  std::filesystem::path root_;
};

}  // namespace fire3dv::doctor

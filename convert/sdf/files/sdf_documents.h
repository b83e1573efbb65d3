// SDF documents of a description: the file and all that it includes, checked and found before libsdformat
// reads them. libsdformat searches includes by itself, in the working directory and in system folders, and
// follows loops until the stack ends; so it gets copies in memory whose includes name each other.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "convert/model.h"
#include "convert/sdf/files/sdf_files.h"

namespace fire3dv::convert {

class SdfDocuments {
 public:
  // warnings: receives includes that are left out.
  SdfDocuments(SdfFiles& files, Sources& sources, std::vector<std::string>& warnings)
      : files_(files), sources_(sources), warnings_(warnings) {}
  ~SdfDocuments();
  SdfDocuments(const SdfDocuments&) = delete;
  SdfDocuments& operator=(const SdfDocuments&) = delete;

  // Returns the path of the copy, which exists as long as this object.
  Result<std::string> open(const std::filesystem::path& file);

  // File of a copy; the path itself for others.
  std::filesystem::path original(const std::string& copy) const;
  // Replaces paths of copies in a message of libsdformat.
  std::string with_originals(std::string message) const;

 private:
  struct Document {
    std::filesystem::path file;
    std::string copy;
    size_t elements = 0;   // with those of its includes, each time that they are included
    bool is_open = false;  // its includes are being read
  };

  Result<const Document*> read(const std::filesystem::path& file, size_t level);
  Result<std::string> prepare(Document& document, std::string text, size_t level);
  Result<const Document*> included(const std::string& uri, const std::filesystem::path& from, size_t level);
  Result<std::string> copy_of(std::string_view text);

  SdfFiles& files_;
  Sources& sources_;
  std::vector<std::string>& warnings_;
  std::map<std::filesystem::path, Document> documents_;  // by their resolved paths
  std::vector<int> descriptors_;
};

}  // namespace fire3dv::convert

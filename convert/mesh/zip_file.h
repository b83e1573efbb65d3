// Reader of ZIP archives in memory, for 3MF: stored and deflated files, without encryption and ZIP64.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "base/error.h"

namespace fire3dv::convert {

class ZipFile {
 public:
  // Borrows the bytes. The error has the reason without the file's name.
  static Result<ZipFile> open(std::string_view bytes);

  bool has(const std::string& name) const { return entries_.contains(name); }
  // Contents of a file of at most max_bytes.
  Result<std::string> read(const std::string& name, uint64_t max_bytes) const;

 private:
  struct Entry {
    uint64_t method = 0, packed_bytes = 0, bytes = 0, header_at = 0;
  };
  explicit ZipFile(std::string_view bytes) : bytes_(bytes) {}

  std::string_view bytes_;
  std::map<std::string, Entry> entries_;
};

}  // namespace fire3dv::convert

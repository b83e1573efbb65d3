// Messages of libsdformat as warnings: its console, and what it writes to std::cerr while it reads included
// files.
#pragma once

#include <sdf/Console.hh>

#include <iosfwd>
#include <sstream>
#include <string>
#include <vector>

#include "convert/sdf/files/sdf_documents.h"

namespace sdf {
inline namespace SDF_VERSION_NAMESPACE {
class Error;
}
}  // namespace sdf

namespace fire3dv::convert {

// Catches the messages as long as it exists. Changes std::cerr and std::cout of the process.
class SdfMessages {
 public:
  explicit SdfMessages(const SdfDocuments& documents);
  ~SdfMessages();
  SdfMessages(const SdfMessages&) = delete;
  SdfMessages& operator=(const SdfMessages&) = delete;

  void add(const sdf::Error& error);
  // Messages since the last call, one a line: file, line number where known, reason. Equal ones once.
  std::vector<std::string> take();

 private:
  void add(std::string message);

  const SdfDocuments& documents_;
  std::ostringstream text_;
  std::ostream* console_;
  std::streambuf *error_buffer_, *output_buffer_;
  std::vector<std::string> messages_;
  size_t left_out_ = 0;
};

}  // namespace fire3dv::convert

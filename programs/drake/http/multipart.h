// Parser of multipart/form-data bodies (RFC 7578). The body is untrusted; parts are views of it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::drake {

struct FormPart {
  std::string name;
  bool is_file = false;   // it has a file name, which is not kept
  std::string_view data;  // in the body
};

struct MultipartLimits {
  size_t max_parts = 64;
  size_t max_header_bytes = 4096;  // of one part
};

// content_type: value of the request's Content-Type, which names the boundary.
Result<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view content_type,
                                              const MultipartLimits& limits = {});

}  // namespace fire3dv::drake

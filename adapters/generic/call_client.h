// Exceptions of the C++ client as results, for adapters.
#pragma once

#include <fire3dv/client.hpp>
#include <string>
#include <utility>

#include "base/error.h"

namespace fire3dv {

// Calls `call`, and converts an exception of the client to an error that names the action and the URI.
template <typename Call>
Result<void> call_client(const std::string& what, const std::string& uri, Call&& call) {
  try {
    std::forward<Call>(call)();
  } catch (const ClientError& error) {
    return Error{what + " " + uri + ": " + error.what()};
  }
  return {};
}

}  // namespace fire3dv

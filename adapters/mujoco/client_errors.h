// Conversion of client exceptions to errors that name the action and the URI.
#pragma once

#include <fire3dv/client.hpp>

#include <string>

#include "protocol/base/error.h"

namespace fire3dv::mujoco {

template <typename Call>
Result<void> told(const char* what, const std::string& uri, Call&& call) {
  try {
    call();
  } catch (const ClientError& error) {
    return Error{std::string(what) + " " + uri + ": " + error.what()};
  }
  return {};
}

}  // namespace fire3dv::mujoco

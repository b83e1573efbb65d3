// Per-thread error of a C call: a return code and a message for fire3dv_last_error. Setting it allocates
// nothing.
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "fire3dv/client.h"

namespace fire3dv::client {

// Stores the message, truncated to the thread's buffer of 1023 bytes, and returns the code.
int fail(int code, std::string_view sentence) noexcept;

const char* last_error() noexcept;

// Runs the body of a C function and converts exceptions to codes, since none may reach C callers. Only
// resource failures throw here.
template <typename Body>
int guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return fail(FIRE3DV_ERROR_SYSTEM, "out of memory");
  } catch (const std::exception& thrown) {
    return fail(FIRE3DV_ERROR_SYSTEM, thrown.what());
  }
}

}  // namespace fire3dv::client

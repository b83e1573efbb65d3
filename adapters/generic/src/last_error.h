// The error of a C call: a code to return and a sentence to keep for fire3dv_last_error.
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "fire3dv/client.h"

namespace fire3dv::client {

// Keeps the sentence (cut to what the thread's buffer holds; nothing is allocated) and returns the code.
int fail(int code, std::string_view sentence) noexcept;

const char* last_error() noexcept;

// Runs the body of a C function. Nothing may be thrown into a caller's C code; what is thrown here is a lack
// of memory or of another resource.
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

// Validation messages that are known to be wrong. Every other message of core or synchronisation validation
// fails the test that caused it. An entry names the message id, the layer version it was seen with and the
// reason.
#pragma once

#include <array>
#include <string_view>

namespace fire3dv::gpu {

struct ValidationException {
  std::string_view message_id;
  std::string_view layer_version;
  std::string_view reason;
};

inline constexpr std::array<ValidationException, 0> kValidationExceptions{};

}  // namespace fire3dv::gpu

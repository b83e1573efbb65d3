// Known false validation messages. Every other message of core or synchronisation validation fails its test.
// An entry has the message id, the layer version and the reason.
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

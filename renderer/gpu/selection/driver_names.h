// Names and versions of drivers and vendors of GPUs. Needs no Vulkan.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace fire3dv::gpu {

// PCI identifiers of vendors.
inline constexpr uint32_t kNvidia = 0x10de, kAmd = 0x1002, kIntel = 0x8086;

// Of GPUs that can have a Vulkan driver; null: another one. Display controllers of virtual machines and
// server consoles have none.
inline const char* vendor_name(uint32_t vendor_id) {
  switch (vendor_id) {
    case kNvidia:
      return "NVIDIA";
    case kAmd:
      return "AMD";
    case kIntel:
      return "Intel";
    default:
      return nullptr;
  }
}

// Major version of Mesa whose software driver has all that is required, and ray query.
inline constexpr int kGoodMesa = 25;

// "22.3" of "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"; empty: another driver.
inline std::string mesa_version(std::string_view driver) {
  constexpr std::string_view kMesa = "Mesa ";
  const size_t at = driver.find(kMesa);
  if (at == std::string_view::npos) return "";
  const std::string_view rest = driver.substr(at + kMesa.size());
  const size_t minor = rest.find('.');
  if (minor == std::string_view::npos) return "";
  return std::string(rest.substr(0, rest.find_first_not_of("0123456789", minor + 1)));
}

}  // namespace fire3dv::gpu

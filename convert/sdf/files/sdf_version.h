// Version of an SDF document.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace fire3dv::convert {

// Newest version that libsdformat 12 reads: 1.9.
constexpr unsigned kNewestSdfMinorVersion = 9;

// 6 of "1.6" and "1.6.1"; empty for what is no version of SDF 1.
inline std::optional<unsigned> minor_sdf_version(std::string_view version) {
  if (!version.starts_with("1.")) return std::nullopt;
  version.remove_prefix(2);
  unsigned minor = 0;
  const auto [end, error] = std::from_chars(version.data(), version.data() + version.size(), minor);
  const std::string_view rest(end, static_cast<size_t>(version.data() + version.size() - end));
  if (error != std::errc() || minor > 900) return std::nullopt;
  if (!rest.empty() &&
      (rest.front() != '.' || rest.find_first_not_of("0123456789.") != std::string_view::npos))
    return std::nullopt;
  return minor;
}

}  // namespace fire3dv::convert

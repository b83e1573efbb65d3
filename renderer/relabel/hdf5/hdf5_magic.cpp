#include <array>
#include <fstream>
#include <string_view>
#include <system_error>

#include "renderer/relabel/hdf5/hdf5_table.h"

namespace fire3dv::relabel {

bool is_hdf5_file(const std::filesystem::path& file) {
  constexpr std::string_view kMagic("\x89HDF\r\n\x1a\n", 8);
  std::array<char, kMagic.size()> begin{};
  std::error_code fault;
  if (!std::filesystem::is_regular_file(file, fault)) return false;
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == kMagic;
}

}  // namespace fire3dv::relabel

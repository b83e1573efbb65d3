#include "renderer/sinks/npy.h"

#include <bit>
#include <string>

#include "protocol/base/file_io.h"

namespace fire3dv::sinks {

static_assert(std::endian::native == std::endian::little, "planes are written as they lie in memory");

std::vector<uint8_t> encode_npy(const FramePlane& plane, uint32_t width, uint32_t height) {
  const wire::ImageOutputInfo& info = wire::info_of(plane.output);
  std::string shape = std::to_string(height) + ", " + std::to_string(width);
  if (info.channels > 1) shape += ", " + std::to_string(info.channels);
  std::string header =
      "{'descr': '" + std::string(info.numpy_type) + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  // The format requires data at a multiple of 64 bytes, after a line feed.
  constexpr size_t kBefore = 10;
  header.append(63 - (kBefore + header.size()) % 64, ' ');
  header += '\n';
  std::vector<uint8_t> bytes{0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0};
  bytes.push_back(static_cast<uint8_t>(header.size() & 0xff));
  bytes.push_back(static_cast<uint8_t>(header.size() >> 8));
  bytes.reserve(bytes.size() + header.size() + plane.bytes.size());
  bytes.insert(bytes.end(), header.begin(), header.end());
  bytes.insert(bytes.end(), plane.bytes.begin(), plane.bytes.end());
  return bytes;
}

Result<void> write_npy(const std::filesystem::path& path, const FramePlane& plane, uint32_t width,
                       uint32_t height, base::Durability durability) {
  return write_whole_file(path, encode_npy(plane, width, height), durability);
}

}  // namespace fire3dv::sinks

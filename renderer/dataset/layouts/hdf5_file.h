// Writer of small HDF5 files in memory: groups, arrays, arrays over other files, and text attributes. The
// same calls give the same bytes. One thread at a time uses the library, but for packing; callers need no
// lock.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::dataset {

enum class Hdf5Type : uint8_t { u8, i32, u32, f16, f32, f64 };
constexpr size_t bytes_of(Hdf5Type type) {
  return type == Hdf5Type::u8 ? 1 : type == Hdf5Type::f16 ? 2 : type == Hdf5Type::f64 ? 8 : 4;
}

class Hdf5File {
 public:
  // The error names the missing library; nothing is written to a disk.
  static Result<Hdf5File> create();
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();

  // Paths begin with '/'; groups come before their contents.
  void add_group(const std::string& path);
  // values: little-endian, the last index first. is_packed: deflated, in one chunk.
  void add_array(const std::string& path, Hdf5Type type, const std::vector<uint64_t>& shape,
                 std::span<const uint8_t> values, bool is_packed);
  template <typename T>
  void add_numbers(const std::string& path, Hdf5Type type, const std::vector<uint64_t>& shape,
                   const std::vector<T>& values) {
    FIRE3DV_ASSERT(sizeof(T) == bytes_of(type));
    add_array(path, type, shape, {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)},
              false);
  }
  // Array of shape (files, shape...): element i is the array `source` of the file files[i], whose name is
  // relative to this file. Of a file that cannot be read, floats are NaN and uint32 is 4294967295 (others:
  // 0).
  void add_virtual_array(const std::string& path, Hdf5Type type, const std::vector<uint64_t>& shape,
                         const std::vector<std::string>& files, const std::string& source);
  // Attribute of an array or group.
  void add_text(const std::string& path, const std::string& name, const std::string& text);

  // Bytes of the file. The error of any call before is returned here. Nothing may be added afterwards.
  Result<std::vector<uint8_t>> finish();

 private:
  struct State;
  explicit Hdf5File(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Bytes of an array of a file, which must have so many elements of this type. Arrays whose values are in
// other files are refused, since another program may have named any file.
Result<std::vector<uint8_t>> read_hdf5_bytes(const std::filesystem::path& file, const std::string& path,
                                             uint64_t count);

// Error if the library is missing.
Result<void> can_write_hdf5();

}  // namespace fire3dv::dataset

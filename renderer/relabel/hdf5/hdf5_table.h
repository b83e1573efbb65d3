// Tables of numbers in HDF5 files of other programs, and the names in their groups. Files are untrusted:
// sizes are limited, and links to other files are refused. One thread at a time may use the library.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::relabel {

bool is_hdf5_file(const std::filesystem::path& file);

// Names of the members of a group such as "/data": those with numbers at their ends in the order of these.
Result<std::vector<std::string>> list_hdf5_group(const std::filesystem::path& file, const std::string& group);

// Array of two dimensions, whose numbers are converted to double. Reads some rows at a time.
class Hdf5Table {
 public:
  static Result<Hdf5Table> open(const std::filesystem::path& file, const std::string& path);
  Hdf5Table(Hdf5Table&& other) noexcept;
  Hdf5Table& operator=(Hdf5Table&&) = delete;
  ~Hdf5Table();

  uint64_t rows() const;
  uint64_t columns() const;
  // Valid until the next call. index: below rows().
  Result<std::span<const double>> row(uint64_t index);

 private:
  struct State;
  explicit Hdf5Table(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::relabel

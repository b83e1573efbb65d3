// In place of hdf5_table.cpp in builds without libhdf5-dev: every file is refused.
#include "renderer/relabel/hdf5/hdf5_table.h"

#include <utility>

namespace fire3dv::relabel {
namespace {

Error absent() {
  return Error{"this program was built without HDF5 (libhdf5-dev): it cannot read such files"};
}

}  // namespace

struct Hdf5Table::State {};

Result<std::vector<std::string>> list_hdf5_group(const std::filesystem::path&, const std::string&) {
  return absent();
}
Result<Hdf5Table> Hdf5Table::open(const std::filesystem::path&, const std::string&) {
  return absent();
}
Hdf5Table::Hdf5Table(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5Table::Hdf5Table(Hdf5Table&& other) noexcept = default;
Hdf5Table::~Hdf5Table() = default;
uint64_t Hdf5Table::rows() const {
  return 0;
}
uint64_t Hdf5Table::columns() const {
  return 0;
}
Result<std::span<const double>> Hdf5Table::row(uint64_t) {
  return absent();
}

}  // namespace fire3dv::relabel

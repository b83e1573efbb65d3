// In place of hdf5_file.cpp and hdf5_library.cpp in builds without libhdf5-dev: every file is refused.
#include "renderer/dataset/layouts/hdf5_file.h"

namespace fire3dv::dataset {
namespace {

Error absent() {
  return Error{"this program was built without HDF5 (libhdf5-dev): choose another --format"};
}

}  // namespace

struct Hdf5File::State {};

Result<void> can_write_hdf5() {
  return absent();
}
Result<Hdf5File> Hdf5File::create() {
  return absent();
}
Hdf5File::Hdf5File(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5File::Hdf5File(Hdf5File&& other) noexcept = default;
Hdf5File::~Hdf5File() = default;
void Hdf5File::add_group(const std::string&) {}
void Hdf5File::add_array(const std::string&, Hdf5Type, const std::vector<uint64_t>&, std::span<const uint8_t>,
                         bool) {}
void Hdf5File::add_virtual_array(const std::string&, Hdf5Type, const std::vector<uint64_t>&,
                                 const std::vector<std::string>&, const std::string&) {}
void Hdf5File::add_text(const std::string&, const std::string&, const std::string&) {}
Result<std::vector<uint8_t>> Hdf5File::finish() {
  return absent();
}
Result<std::vector<uint8_t>> read_hdf5_bytes(const std::filesystem::path&, const std::string&, uint64_t) {
  return absent();
}

}  // namespace fire3dv::dataset

#include "renderer/dataset/layouts/hdf5_library.h"

#include <dlfcn.h>

#include <string>

namespace fire3dv::dataset {
namespace {

// Soname of the headers' library: structures and variables of other versions may differ.
constexpr const char* kNames[] = {"libhdf5_serial.so." FIRE3DV_HDF5_SOVERSION,
                                  "libhdf5.so." FIRE3DV_HDF5_SOVERSION};

Result<Hdf5Library> load() {
  void* library = nullptr;
  for (const char* name : kNames) {
    if (!library) library = ::dlopen(name, RTLD_NOW | RTLD_LOCAL);
  }
  if (!library)
    return Error{std::string("--format hdf5 needs ") + kNames[0] +
                 ", which is not there: install the package " FIRE3DV_HDF5_PACKAGE
                 ", or choose another format"};
  Hdf5Library table;
  std::string missing;
  const auto find = [&](const char* name) {
    void* const found = ::dlsym(library, name);
    if (!found && missing.empty()) missing = name;
    return found;
  };
#define FIRE3DV_HDF5_FIND(function) \
  table.function = reinterpret_cast<decltype(table.function)>(find(#function));
  FIRE3DV_HDF5_FUNCTIONS(FIRE3DV_HDF5_FIND)
#undef FIRE3DV_HDF5_FIND
  if (missing.empty() && table.H5open() >= 0) {
#define FIRE3DV_HDF5_FIND(identifier) \
  if (const void* const value = find(#identifier)) table.identifier = *static_cast<const hid_t*>(value);
    FIRE3DV_HDF5_IDENTIFIERS(FIRE3DV_HDF5_FIND)
#undef FIRE3DV_HDF5_FIND
    table.H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are returned, not printed
  }
  if (!missing.empty())
    return Error{"the HDF5 library of this system has no " + missing + ": choose another --format"};
  return table;
}

}  // namespace

Result<const Hdf5Library*> load_hdf5() {
  static const Result<Hdf5Library> loaded = load();
  if (!loaded) return loaded.error();
  return &*loaded;
}

}  // namespace fire3dv::dataset

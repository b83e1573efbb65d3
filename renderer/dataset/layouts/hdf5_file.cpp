#include "renderer/dataset/layouts/hdf5_file.h"

#include <zlib.h>

#include <mutex>
#include <utility>

#include "base/files.h"
#include "renderer/dataset/layouts/hdf5_library.h"
#include "renderer/dataset/layouts/layout.h"

namespace fire3dv::dataset {
namespace {

// H5F_ACC_RDONLY and H5F_ACC_TRUNC, whose macros call the library by its name.
constexpr unsigned kReadOnly = 0, kTruncate = 2;
constexpr unsigned kDeflateLevel = 1;  // the encoder shares its cores with the renderer

// The library has one lock of its own, if any.
std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

// Closes an identifier at the end of the scope.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

std::vector<hsize_t> extents(const std::vector<uint64_t>& shape) {
  return {shape.begin(), shape.end()};
}

// The identifier, or that of a failure. Close it.
template <typename Close>
hid_t checked(hid_t id, bool is_good, Close close) {
  if (is_good || id < 0) return id;
  close(id);
  return -1;
}

// In memory, with the oldest format that holds the contents: newer ones have times of groups.
hid_t memory_access(const Hdf5Library& hdf5) {
  const hid_t access = hdf5.H5Pcreate(hdf5.H5P_CLS_FILE_ACCESS_ID_g);
  constexpr size_t kGrowth = 1 << 20;
  return checked(access, hdf5.H5Pset_fapl_core(access, kGrowth, false) >= 0, hdf5.H5Pclose);
}

// Files that are open at once need names of their own. Under the lock.
std::string memory_name() {
  static uint64_t made = 0;
  return "memory " + std::to_string(made++);
}

// IEEE 754 binary16.
hid_t make_half(const Hdf5Library& hdf5) {
  const hid_t half = hdf5.H5Tcopy(hdf5.H5T_IEEE_F32LE_g);
  const bool is_good = hdf5.H5Tset_fields(half, 15, 10, 5, 0, 10) >= 0 && hdf5.H5Tset_size(half, 2) >= 0 &&
                       hdf5.H5Tset_ebias(half, 15) >= 0;
  return checked(half, is_good, hdf5.H5Tclose);
}

// Close it.
hid_t copy_type(const Hdf5Library& hdf5, Hdf5Type type) {
  switch (type) {
    case Hdf5Type::u8:
      return hdf5.H5Tcopy(hdf5.H5T_STD_U8LE_g);
    case Hdf5Type::i32:
      return hdf5.H5Tcopy(hdf5.H5T_STD_I32LE_g);
    case Hdf5Type::u32:
      return hdf5.H5Tcopy(hdf5.H5T_STD_U32LE_g);
    case Hdf5Type::f16:
      return make_half(hdf5);
    case Hdf5Type::f32:
      return hdf5.H5Tcopy(hdf5.H5T_IEEE_F32LE_g);
    case Hdf5Type::f64:
      return hdf5.H5Tcopy(hdf5.H5T_IEEE_F64LE_g);
  }
  return -1;
}

// Without times, which would differ between runs.
hid_t array_settings(const Hdf5Library& hdf5) {
  const hid_t settings = hdf5.H5Pcreate(hdf5.H5P_CLS_DATASET_CREATE_ID_g);
  return checked(settings, hdf5.H5Pset_obj_track_times(settings, false) >= 0, hdf5.H5Pclose);
}

// Elements whose file cannot be read, little-endian: NaN of floats, and the largest uint32, which no instance
// has. Empty: 0.
std::vector<uint8_t> fill_value(Hdf5Type type) {
  switch (type) {
    case Hdf5Type::f16:
      return {0, 0x7e};
    case Hdf5Type::f32:
      return {0, 0, 0xc0, 0x7f};
    case Hdf5Type::f64:
      return {0, 0, 0, 0, 0, 0, 0xf8, 0x7f};
    case Hdf5Type::u32:
      return {0xff, 0xff, 0xff, 0xff};
    case Hdf5Type::u8:
    case Hdf5Type::i32:
      break;
  }
  return {};
}

// As the library's filters "shuffle" and "deflate" do it. Without its lock, so that several images are packed
// at once. Empty: it failed.
std::vector<uint8_t> pack(std::span<const uint8_t> values, size_t element_bytes) {
  std::vector<uint8_t> shuffled(values.size());
  const size_t elements = values.size() / element_bytes;
  for (size_t byte = 0; byte < element_bytes; ++byte) {
    for (size_t i = 0; i < elements; ++i) shuffled[byte * elements + i] = values[i * element_bytes + byte];
  }
  uLongf bytes = ::compressBound(shuffled.size());
  std::vector<uint8_t> packed(bytes);
  if (::compress2(packed.data(), &bytes, shuffled.data(), shuffled.size(), kDeflateLevel) != Z_OK) return {};
  packed.resize(bytes);
  return packed;
}

// Of arrays in other files.
herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
  return -1;
}

}  // namespace

struct Hdf5File::State {
  const Hdf5Library& hdf5;
  hid_t file = -1;
  std::string fault;  // first path that failed

  void check(bool is_good, const std::string& path) {
    if (!is_good && fault.empty()) fault = path;
  }
  ~State() {
    if (file >= 0) hdf5.H5Fclose(file);
  }
};

Result<void> can_write_hdf5() {
  const std::lock_guard lock(library_mutex());
  if (auto hdf5 = load_hdf5(); !hdf5) return hdf5.error();
  return {};
}

Result<Hdf5File> Hdf5File::create() {
  const std::lock_guard lock(library_mutex());
  auto hdf5 = load_hdf5();
  if (!hdf5) return hdf5.error();
  const Handle access(memory_access(**hdf5), (*hdf5)->H5Pclose);
  const hid_t file =
      access.get() < 0 ? -1 : (*hdf5)->H5Fcreate(memory_name().c_str(), kTruncate, H5P_DEFAULT, access.get());
  if (file < 0) return Error{"the HDF5 library cannot make a file in memory"};
  return Hdf5File(std::unique_ptr<State>(new State{**hdf5, file, {}}));
}

Hdf5File::Hdf5File(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5File::Hdf5File(Hdf5File&& other) noexcept = default;
Hdf5File::~Hdf5File() {
  if (!state_) return;  // moved from, perhaps in create()
  const std::lock_guard lock(library_mutex());
  state_.reset();
}

void Hdf5File::add_group(const std::string& path) {
  const std::lock_guard lock(library_mutex());
  const Handle group(
      state_->hdf5.H5Gcreate2(state_->file, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      state_->hdf5.H5Gclose);
  state_->check(group.get() >= 0, path);
}

void Hdf5File::add_array(const std::string& path, Hdf5Type type, const std::vector<uint64_t>& shape,
                         std::span<const uint8_t> values, bool is_packed) {
  uint64_t elements = 1;
  for (const uint64_t extent : shape) elements *= extent;
  FIRE3DV_ASSERT(values.size() == elements * bytes_of(type));
  is_packed = is_packed && elements != 0;
  const std::vector<uint8_t> packed = is_packed ? pack(values, bytes_of(type)) : std::vector<uint8_t>();
  const std::lock_guard lock(library_mutex());
  const Hdf5Library& hdf5 = state_->hdf5;
  const std::vector<hsize_t> sizes = extents(shape);
  const auto rank = static_cast<int>(sizes.size());
  const Handle element(copy_type(hdf5, type), hdf5.H5Tclose);
  const Handle space(hdf5.H5Screate_simple(rank, sizes.data(), nullptr), hdf5.H5Sclose);
  const Handle settings(array_settings(hdf5), hdf5.H5Pclose);
  bool is_good = element.get() >= 0 && space.get() >= 0 && settings.get() >= 0;
  if (is_packed)
    is_good = is_good && !packed.empty() && hdf5.H5Pset_chunk(settings.get(), rank, sizes.data()) >= 0 &&
              hdf5.H5Pset_shuffle(settings.get()) >= 0 &&
              hdf5.H5Pset_deflate(settings.get(), kDeflateLevel) >= 0;
  const Handle array(is_good ? hdf5.H5Dcreate2(state_->file, path.c_str(), element.get(), space.get(),
                                               H5P_DEFAULT, settings.get(), H5P_DEFAULT)
                             : -1,
                     hdf5.H5Dclose);
  const auto write = [&] {
    if (elements == 0) return true;
    const std::vector<hsize_t> first(sizes.size());
    return is_packed
               ? hdf5.H5Dwrite_chunk(array.get(), H5P_DEFAULT, 0, first.data(), packed.size(),
                                     packed.data()) >= 0
               : hdf5.H5Dwrite(array.get(), element.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
  };
  state_->check(array.get() >= 0 && write(), path);
}

void Hdf5File::add_virtual_array(const std::string& path, Hdf5Type type, const std::vector<uint64_t>& shape,
                                 const std::vector<std::string>& files, const std::string& source) {
  const std::lock_guard lock(library_mutex());
  const Hdf5Library& hdf5 = state_->hdf5;
  std::vector<hsize_t> sizes = extents(shape);
  const Handle from(hdf5.H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr),
                    hdf5.H5Sclose);
  sizes.insert(sizes.begin(), files.size());
  const Handle to(hdf5.H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr),
                  hdf5.H5Sclose);
  const Handle settings(array_settings(hdf5), hdf5.H5Pclose);
  const Handle element(copy_type(hdf5, type), hdf5.H5Tclose);
  const std::vector<uint8_t> fill = fill_value(type);
  bool is_good = from.get() >= 0 && to.get() >= 0 && settings.get() >= 0 && element.get() >= 0 &&
                 (fill.empty() || hdf5.H5Pset_fill_value(settings.get(), element.get(), fill.data()) >= 0);
  std::vector<hsize_t> start(sizes.size()), count = sizes;
  count[0] = 1;
  for (size_t i = 0; i < files.size() && is_good; ++i) {
    start[0] = i;
    is_good =
        hdf5.H5Sselect_hyperslab(to.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >=
            0 &&
        hdf5.H5Pset_virtual(settings.get(), to.get(), files[i].c_str(), source.c_str(), from.get()) >= 0;
  }
  const Handle array(is_good ? hdf5.H5Dcreate2(state_->file, path.c_str(), element.get(), to.get(),
                                               H5P_DEFAULT, settings.get(), H5P_DEFAULT)
                             : -1,
                     hdf5.H5Dclose);
  state_->check(array.get() >= 0, path);
}

void Hdf5File::add_text(const std::string& path, const std::string& name, const std::string& text) {
  const std::lock_guard lock(library_mutex());
  const Hdf5Library& hdf5 = state_->hdf5;
  const Handle type(hdf5.H5Tcopy(hdf5.H5T_C_S1_g), hdf5.H5Tclose);
  const bool is_good = hdf5.H5Tset_size(type.get(), H5T_VARIABLE) >= 0 &&  // h5py reads others as bytes
                       hdf5.H5Tset_cset(type.get(), H5T_CSET_UTF8) >= 0;
  const char* const value = text.c_str();
  const Handle space(hdf5.H5Screate(H5S_SCALAR), hdf5.H5Sclose);
  const bool is_root = path == "/";
  const Handle object(is_root ? -1 : hdf5.H5Dopen2(state_->file, path.c_str(), H5P_DEFAULT), hdf5.H5Dclose);
  const Handle attribute(hdf5.H5Acreate2(is_root ? state_->file : object.get(), name.c_str(), type.get(),
                                         space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         hdf5.H5Aclose);
  state_->check(is_good && attribute.get() >= 0 && hdf5.H5Awrite(attribute.get(), type.get(), &value) >= 0,
                path + "@" + name);
}

Result<std::vector<uint8_t>> Hdf5File::finish() {
  const std::lock_guard lock(library_mutex());
  const Hdf5Library& hdf5 = state_->hdf5;
  if (!state_->fault.empty()) return Error{"the HDF5 library cannot write " + state_->fault};
  if (hdf5.H5Fflush(state_->file, H5F_SCOPE_LOCAL) < 0) return Error{"the HDF5 library cannot end a file"};
  const ssize_t size = hdf5.H5Fget_file_image(state_->file, nullptr, 0);
  if (size <= 0) return Error{"the HDF5 library has no bytes of a file"};
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  if (hdf5.H5Fget_file_image(state_->file, bytes.data(), bytes.size()) != size)
    return Error{"the HDF5 library has no bytes of a file"};
  return bytes;
}

Result<std::vector<uint8_t>> read_hdf5_bytes(const std::filesystem::path& file, const std::string& path,
                                             uint64_t count) {
  // From memory: the library locks files that it opens itself, which some file systems refuse.
  auto image = read_whole_file(file, kMaxFileBytes);
  if (!image) return image.error();
  const std::lock_guard lock(library_mutex());
  auto loaded = load_hdf5();
  if (!loaded) return loaded.error();
  const Hdf5Library& hdf5 = **loaded;
  const Error fault{file.string() + " has no array " + path + " of " + std::to_string(count) +
                    " elements: remove it, and run the same command again"};
  const Handle memory(memory_access(hdf5), hdf5.H5Pclose);
  if (memory.get() < 0 || hdf5.H5Pset_file_image(memory.get(), image->data(), image->size()) < 0)
    return fault;
  const Handle opened(hdf5.H5Fopen(memory_name().c_str(), kReadOnly, memory.get()), hdf5.H5Fclose);
  if (opened.get() < 0) return fault;
  const Handle access(hdf5.H5Pcreate(hdf5.H5P_CLS_DATASET_ACCESS_ID_g), hdf5.H5Pclose);
  if (hdf5.H5Pset_elink_cb(access.get(), refuse_link, nullptr) < 0) return fault;
  const Handle array(hdf5.H5Dopen2(opened.get(), path.c_str(), access.get()), hdf5.H5Dclose);
  if (array.get() < 0) return fault;
  const Handle settings(hdf5.H5Dget_create_plist(array.get()), hdf5.H5Pclose);
  const H5D_layout_t layout = hdf5.H5Pget_layout(settings.get());
  if ((layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS) || hdf5.H5Pget_external_count(settings.get()) != 0)
    return fault;
  const Handle space(hdf5.H5Dget_space(array.get()), hdf5.H5Sclose);
  if (space.get() < 0 || hdf5.H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(count))
    return fault;
  std::vector<uint8_t> bytes(count);
  if (hdf5.H5Dread(array.get(), hdf5.H5T_STD_U8LE_g, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0)
    return fault;
  return bytes;
}

}  // namespace fire3dv::dataset

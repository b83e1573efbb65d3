#include "renderer/relabel/hdf5/hdf5_table.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "renderer/dataset/layouts/hdf5_library.h"

namespace fire3dv::relabel {
namespace {

using dataset::Hdf5Library;

constexpr unsigned kReadOnly = 0;  // H5F_ACC_RDONLY, whose macro calls the library by its name
constexpr uint64_t kMaxColumns = 1'000'000;
constexpr uint64_t kMaxMembers = 1'000'000;     // of a group
constexpr uint64_t kBlockNumbers = 1 << 17;     // that are read at a time
constexpr uint64_t kMaxChunkNumbers = 1 << 25;  // the library reads whole chunks

// Closes an identifier.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }
  bool is_open() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
  return -1;
}

Result<const Hdf5Library*> load() {
  Result<const Hdf5Library*> loaded = dataset::load_hdf5();
  if (!loaded)
    return Error{"HDF5 files need the library of the package " FIRE3DV_HDF5_PACKAGE ": install it"};
  return loaded;
}

Result<Handle> open_file(const Hdf5Library& hdf5, const std::filesystem::path& file) {
  // Without a lock, which some file systems refuse.
  const Handle access(hdf5.H5Pcreate(hdf5.H5P_CLS_FILE_ACCESS_ID_g), hdf5.H5Pclose);
  if (hdf5.H5Pset_file_locking(access.get(), false, true) < 0)
    return Error{"the HDF5 library has no settings"};
  Handle opened(hdf5.H5Fopen(file.c_str(), kReadOnly, access.get()), hdf5.H5Fclose);
  if (!opened.is_open()) return Error{quote(file.string()) + " cannot be read as HDF5: it is damaged"};
  return opened;
}

// Settings of access that refuse links to other files, which could be any file or pipe. They hold for groups,
// too.
Result<Handle> refuse_links(const Hdf5Library& hdf5) {
  Handle access(hdf5.H5Pcreate(hdf5.H5P_CLS_DATASET_ACCESS_ID_g), hdf5.H5Pclose);
  if (!access.is_open() || hdf5.H5Pset_elink_cb(access.get(), refuse_link, nullptr) < 0)
    return Error{"the HDF5 library has no settings of links"};
  return access;
}

// "demo_9" before "demo_10".
bool comes_before(const std::string& a, const std::string& b) {
  const auto key = [](const std::string& name) {
    const size_t digits = name.size() - (name.find_last_not_of("0123456789") + 1);
    return std::tuple(name.substr(0, name.size() - digits), digits, name);
  };
  return key(a) < key(b);
}

}  // namespace

Result<std::vector<std::string>> list_hdf5_group(const std::filesystem::path& file,
                                                 const std::string& group) {
  const auto loaded = load();
  if (!loaded) return loaded.error();
  const Hdf5Library& hdf5 = **loaded;
  const Result<Handle> opened = open_file(hdf5, file);
  if (!opened) return opened.error();
  const Result<Handle> access = refuse_links(hdf5);
  if (!access) return access.error();
  H5G_info_t info{};
  if (hdf5.H5Gget_info_by_name(opened->get(), group.c_str(), &info, access->get()) < 0)
    return Error{quote(file.string()) + " has no group " + group};
  if (info.nlinks > kMaxMembers) return Error{quote(file.string()) + ": " + group + " has too many members"};
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    std::array<char, 256> name{};
    const ssize_t length = hdf5.H5Lget_name_by_idx(opened->get(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC,
                                                   i, name.data(), name.size(), access->get());
    if (length <= 0 || static_cast<size_t>(length) >= name.size())
      return Error{quote(file.string()) + ": " + group + " has a name that cannot be read"};
    names.emplace_back(name.data());
  }
  std::sort(names.begin(), names.end(), comes_before);
  return names;
}

struct Hdf5Table::State {
  const Hdf5Library& hdf5;
  std::string name;  // for messages
  Handle file, array, space;
  uint64_t rows, columns;
  std::vector<double> block;
  uint64_t block_begin = 0, block_rows = 0;
};

Result<Hdf5Table> Hdf5Table::open(const std::filesystem::path& file, const std::string& path) {
  const auto loaded = load();
  if (!loaded) return loaded.error();
  const Hdf5Library& hdf5 = **loaded;
  Result<Handle> opened = open_file(hdf5, file);
  if (!opened) return opened.error();
  const std::string name = quote(file.string()) + ": " + path;
  const Result<Handle> access = refuse_links(hdf5);
  if (!access) return access.error();
  Handle array(hdf5.H5Dopen2(opened->get(), path.c_str(), access->get()), hdf5.H5Dclose);
  if (!array.is_open()) return Error{quote(file.string()) + " has no array " + path};
  const Handle settings(hdf5.H5Dget_create_plist(array.get()), hdf5.H5Pclose);
  const H5D_layout_t layout = hdf5.H5Pget_layout(settings.get());
  if ((layout != H5D_CHUNKED && layout != H5D_CONTIGUOUS && layout != H5D_COMPACT) ||
      hdf5.H5Pget_external_count(settings.get()) != 0)
    return Error{name + " has its values in other files, which are not read"};
  Handle space(hdf5.H5Dget_space(array.get()), hdf5.H5Sclose);
  std::array<hsize_t, 2> extents{}, chunk{};
  if (hdf5.H5Sget_simple_extent_ndims(space.get()) != 2 ||
      hdf5.H5Sget_simple_extent_dims(space.get(), extents.data(), nullptr) != 2)
    return Error{name + " is no table of rows and columns"};
  if (extents[1] == 0 || extents[1] > kMaxColumns)
    return Error{name + " has " + std::to_string(extents[1]) + " columns"};
  if (layout == H5D_CHUNKED && (hdf5.H5Pget_chunk(settings.get(), 2, chunk.data()) != 2 || chunk[0] == 0 ||
                                chunk[1] > kMaxChunkNumbers / chunk[0]))
    return Error{name + " has chunks that are too large"};
  return Hdf5Table(std::make_unique<State>(
      State{hdf5, name, std::move(*opened), std::move(array), std::move(space), extents[0], extents[1], {}}));
}

Hdf5Table::Hdf5Table(std::unique_ptr<State> state) : state_(std::move(state)) {}
Hdf5Table::Hdf5Table(Hdf5Table&& other) noexcept = default;
Hdf5Table::~Hdf5Table() = default;

uint64_t Hdf5Table::rows() const {
  return state_->rows;
}
uint64_t Hdf5Table::columns() const {
  return state_->columns;
}

Result<std::span<const double>> Hdf5Table::row(uint64_t index) {
  State& state = *state_;
  if (index < state.block_begin || index >= state.block_begin + state.block_rows) {
    const Hdf5Library& hdf5 = state.hdf5;
    const uint64_t count = std::min(std::max<uint64_t>(kBlockNumbers / state.columns, 1), state.rows - index);
    const std::array<hsize_t, 2> begin{index, 0}, size{count, state.columns};
    const Handle memory(hdf5.H5Screate_simple(2, size.data(), nullptr), hdf5.H5Sclose);
    state.block.resize(count * state.columns);
    if (hdf5.H5Sselect_hyperslab(state.space.get(), H5S_SELECT_SET, begin.data(), nullptr, size.data(),
                                 nullptr) < 0 ||
        hdf5.H5Dread(state.array.get(), hdf5.H5T_IEEE_F64LE_g, memory.get(), state.space.get(), H5P_DEFAULT,
                     state.block.data()) < 0)
      return Error{state.name + " cannot be read as numbers, from row " + std::to_string(index) + " on"};
    state.block_begin = index;
    state.block_rows = count;
  }
  return std::span<const double>(state.block)
      .subspan((index - state.block_begin) * state.columns, state.columns);
}

}  // namespace fire3dv::relabel

// Function table of the HDF5 library, loaded at run time when a file is made: few runs need it, and it loads
// libraries for network storage. Only sources that read or write such files include this header.
#pragma once

#include <hdf5.h>

#include "base/error.h"

namespace fire3dv::dataset {

// X(function)
#define FIRE3DV_HDF5_FUNCTIONS(X) \
  X(H5open)                       \
  X(H5Eset_auto2)                 \
  X(H5Fcreate)                    \
  X(H5Fopen)                      \
  X(H5Fclose)                     \
  X(H5Fflush)                     \
  X(H5Fget_file_image)            \
  X(H5Gget_info_by_name)          \
  X(H5Lget_name_by_idx)           \
  X(H5Pcreate)                    \
  X(H5Pclose)                     \
  X(H5Pset_fapl_core)             \
  X(H5Pset_file_image)            \
  X(H5Pset_file_locking)          \
  X(H5Pset_obj_track_times)       \
  X(H5Pset_chunk)                 \
  X(H5Pset_shuffle)               \
  X(H5Pset_deflate)               \
  X(H5Pset_fill_value)            \
  X(H5Pset_virtual)               \
  X(H5Pset_elink_cb)              \
  X(H5Pget_layout)                \
  X(H5Pget_chunk)                 \
  X(H5Pget_external_count)        \
  X(H5Screate)                    \
  X(H5Screate_simple)             \
  X(H5Sselect_hyperslab)          \
  X(H5Sget_simple_extent_npoints) \
  X(H5Sget_simple_extent_ndims)   \
  X(H5Sget_simple_extent_dims)    \
  X(H5Sclose)                     \
  X(H5Tcopy)                      \
  X(H5Tset_size)                  \
  X(H5Tset_cset)                  \
  X(H5Tset_fields)                \
  X(H5Tset_ebias)                 \
  X(H5Tclose)                     \
  X(H5Gcreate2)                   \
  X(H5Gclose)                     \
  X(H5Dcreate2)                   \
  X(H5Dopen2)                     \
  X(H5Dget_space)                 \
  X(H5Dget_create_plist)          \
  X(H5Dwrite)                     \
  X(H5Dwrite_chunk)               \
  X(H5Dread)                      \
  X(H5Dclose)                     \
  X(H5Acreate2)                   \
  X(H5Awrite)                     \
  X(H5Aclose)

// X(identifier): variables that H5open() sets.
#define FIRE3DV_HDF5_IDENTIFIERS(X) \
  X(H5P_CLS_FILE_ACCESS_ID_g)       \
  X(H5P_CLS_DATASET_CREATE_ID_g)    \
  X(H5P_CLS_DATASET_ACCESS_ID_g)    \
  X(H5T_STD_U8LE_g)                 \
  X(H5T_STD_I32LE_g)                \
  X(H5T_STD_U32LE_g)                \
  X(H5T_IEEE_F32LE_g)               \
  X(H5T_IEEE_F64LE_g)               \
  X(H5T_C_S1_g)

struct Hdf5Library {
#define FIRE3DV_HDF5_MEMBER(function) decltype(&::function) function = nullptr;
  FIRE3DV_HDF5_FUNCTIONS(FIRE3DV_HDF5_MEMBER)
#undef FIRE3DV_HDF5_MEMBER
#define FIRE3DV_HDF5_MEMBER(identifier) hid_t identifier = -1;
  FIRE3DV_HDF5_IDENTIFIERS(FIRE3DV_HDF5_MEMBER)
#undef FIRE3DV_HDF5_MEMBER
};

// Process-wide table, loaded at the first call. The error names the missing library and its package.
Result<const Hdf5Library*> load_hdf5();

}  // namespace fire3dv::dataset

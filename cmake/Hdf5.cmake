# HDF5, which `fire3dv dataset --format hdf5` loads when it makes a file: FIRE3DV_HDF5_INCLUDE, its headers,
# FIRE3DV_HDF5_SOVERSION, the version in the name of the library that fits them, and FIRE3DV_HDF5_PACKAGE, Debian's
# name of it. Without libhdf5-dev they are empty, and the program refuses the format.
find_path(FIRE3DV_HDF5_INCLUDE hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(FIRE3DV_HDF5_LIBRARY NAMES hdf5_serial hdf5)
mark_as_advanced(FIRE3DV_HDF5_INCLUDE FIRE3DV_HDF5_LIBRARY)
set(FIRE3DV_HDF5_SOVERSION "")
set(FIRE3DV_HDF5_PACKAGE "")
if(FIRE3DV_HDF5_INCLUDE AND FIRE3DV_HDF5_LIBRARY)
  file(REAL_PATH ${FIRE3DV_HDF5_LIBRARY} hdf5_file)
  if(hdf5_file MATCHES "\\.so\\.([0-9]+)")
    set(FIRE3DV_HDF5_SOVERSION ${CMAKE_MATCH_1})
    set(FIRE3DV_HDF5_PACKAGE libhdf5-${CMAKE_MATCH_1})
    if(FIRE3DV_HDF5_SOVERSION EQUAL 103)
      string(APPEND FIRE3DV_HDF5_PACKAGE -1)  # Debian 12
    endif()
  endif()
endif()

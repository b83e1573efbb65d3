# Compiler cache and quick linker, where they are installed.
#
# ccache hits in every clone of the tree: paths count relative to the clone. A launcher of the user's own takes precedence.
option(FIRE3DV_CCACHE "Compile through ccache, where it is installed" ON)
find_program(FIRE3DV_CCACHE_PROGRAM ccache)
mark_as_advanced(FIRE3DV_CCACHE_PROGRAM)
if(FIRE3DV_CCACHE AND FIRE3DV_CCACHE_PROGRAM AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(fire3dv_launcher env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${FIRE3DV_CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${fire3dv_launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${fire3dv_launcher})
endif()

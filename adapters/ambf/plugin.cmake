# AMBF plugin target. Only folders and definitions of AMBF's package file are used; its libraries are not linked, since
# the simulator exports the symbols. A second copy of AMBF's state would be another world.
find_file(ambf_package AMBFConfig.cmake PATHS ${AMBF_DIR} ${AMBF_DIR}/share/AMBF/cmake NO_DEFAULT_PATH NO_CACHE)
if(NOT ambf_package)
  message(FATAL_ERROR "AMBF_DIR is ${AMBF_DIR}, where no AMBFConfig.cmake is: give AMBF's build folder, or leave it out")
endif()
set(AMBF_BINARY_DIR ${AMBF_DIR})  # keeps AMBFConfig.cmake from importing targets and searching for their dependencies
include(${ambf_package})

add_library(fire3dv_ambf_plugin MODULE plugin.cpp)
target_link_libraries(fire3dv_ambf_plugin PRIVATE fire3dv_flags fire3dv_ambf)
target_include_directories(fire3dv_ambf_plugin SYSTEM PRIVATE ${AMBF_INCLUDE_DIRS})
# Same ABI as AMBF's own build: Bullet in double precision, and the alignment of -march=native.
target_compile_options(fire3dv_ambf_plugin PRIVATE ${AMBF_DEFINITIONS} -march=native)
target_link_options(fire3dv_ambf_plugin PRIVATE -Wl,--version-script=${CMAKE_CURRENT_SOURCE_DIR}/exports.map)
set_target_properties(fire3dv_ambf_plugin PROPERTIES
  OUTPUT_NAME fire3dv_ambf
  CXX_VISIBILITY_PRESET hidden
  VISIBILITY_INLINES_HIDDEN ON
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin
  BUILD_WITH_INSTALL_RPATH ON
  LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/exports.map)
install(TARGETS fire3dv_ambf_plugin LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/fire3dv)

# Test plugins of tests/ambf/against_ambf.py and compare_pictures.py.
if(FIRE3DV_TESTS)
  foreach(part driver pictures)
    add_library(ambf_${part} MODULE ${PROJECT_SOURCE_DIR}/tests/ambf/${part}_plugin.cpp)
    target_link_libraries(ambf_${part} PRIVATE fire3dv_flags)
    target_include_directories(ambf_${part} SYSTEM PRIVATE ${AMBF_INCLUDE_DIRS})
    target_compile_options(ambf_${part} PRIVATE ${AMBF_DEFINITIONS} -march=native)
    set_target_properties(ambf_${part} PROPERTIES
      CXX_VISIBILITY_PRESET hidden LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  endforeach()
endif()

# Meshes from files, for all readers; and AMBF's descriptions.
# By pkg-config, because assimp's CMake package links libdraco too, which exports an older tinygltf under the same names:
# linked by a program itself it would come before ours.
find_package(PkgConfig REQUIRED)
pkg_check_modules(assimp REQUIRED IMPORTED_TARGET assimp)

fire3dv_library(fire3dv_mesh_files
  SOURCES import_files.cpp mesh_child.cpp mesh_files.cpp mesh_import.cpp surface_builder.cpp
  LINK fire3dv_convert_model fire3dv_local_files PkgConfig::assimp)

find_package(yaml-cpp REQUIRED)
fire3dv_library(fire3dv_adf
  SOURCES adf_fields.cpp adf_model.cpp adf_objects.cpp adf_visual.cpp adf_yaml.cpp read_adf.cpp adf_shapes.cpp
  LINK fire3dv_mesh_files $<IF:$<TARGET_EXISTS:yaml-cpp::yaml-cpp>,yaml-cpp::yaml-cpp,yaml-cpp>)

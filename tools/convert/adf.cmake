# Meshes from files, for all readers; and AMBF's descriptions.
find_package(assimp REQUIRED)

fire3dv_library(fire3dv_mesh_files
  SOURCES import_files.cpp local_files.cpp mesh_child.cpp mesh_files.cpp mesh_import.cpp surface_builder.cpp
  LINK fire3dv_scene assimp::assimp)

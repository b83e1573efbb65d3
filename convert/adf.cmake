# Mesh files for all readers, and the ADF reader. pkg-config finds assimp, since assimp's CMake package also links
# libdraco. libdraco exports an older tinygltf under the same symbol names, which would take precedence over this
# project's.
find_package(PkgConfig REQUIRED)
pkg_check_modules(assimp REQUIRED IMPORTED_TARGET assimp)

fire3dv_library(fire3dv_mesh_files
  SOURCES mesh/text/dae_repair.cpp mesh/gltf_mesh.cpp mesh/mesh_child.cpp mesh/mesh_files.cpp mesh/mesh_import.cpp
          mesh/mesh_scene.cpp mesh/text/mesh_text.cpp mesh/mtl.cpp mesh/text/obj_text.cpp mesh/ply.cpp mesh/stl.cpp
          mesh/three_mf.cpp mesh/zip_file.cpp
  LINK fire3dv_convert_glb fire3dv_description_files PkgConfig::assimp PkgConfig::tinyxml2 PNG::PNG)

find_package(yaml-cpp REQUIRED)
fire3dv_library(fire3dv_adf
  SOURCES adf/adf_joints.cpp adf/adf_yaml.cpp adf/read_adf.cpp adf/adf_objects.cpp adf/adf_visual.cpp
  LINK fire3dv_mesh_files $<IF:$<TARGET_EXISTS:yaml-cpp::yaml-cpp>,yaml-cpp::yaml-cpp,yaml-cpp>)

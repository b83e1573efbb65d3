# SDF scenes as plain data, and their rules: shapes, materials, lights, cameras and URIs of Gazebo. They need no
# libsdformat; fire3dv-gazebo uses them, too.
fire3dv_library(fire3dv_sdf_scene
  SOURCES sdf/add_sdf.cpp sdf/sdf_kinematics.cpp sdf/sdf_materials.cpp sdf/sdf_prism.cpp sdf/sdf_scripts.cpp
          sdf/sdf_shapes.cpp sdf/sdf_warnings.cpp sdf/files/sdf_files.cpp
  LINK fire3dv_mesh_files fire3dv_xacro PkgConfig::tinyxml2)

# Files, through libsdformat 12: Debian 12 has it, Debian 13 does not.
pkg_check_modules(sdformat IMPORTED_TARGET sdformat12)
if(TARGET PkgConfig::sdformat)
  fire3dv_library(fire3dv_sdf_reader
    SOURCES sdf/library/read_sdf.cpp sdf/files/sdf_documents.cpp sdf/files/sdf_include_text.cpp
            sdf/library/sdf_appearance.cpp sdf/library/sdf_joints.cpp sdf/library/sdf_messages.cpp
            sdf/library/sdf_reader.cpp sdf/library/sdf_trial.cpp
    LINK fire3dv_sdf_scene PkgConfig::sdformat)
  add_library(fire3dv_sdf ALIAS fire3dv_sdf_reader)
else()
  message(STATUS "libsdformat 12 (libsdformat-dev) is missing: fire3dv-convert reads no SDF")
  fire3dv_library(fire3dv_sdf SOURCES sdf/no_sdf.cpp LINK fire3dv_convert_model)
endif()

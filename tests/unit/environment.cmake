# Environment images and material records.
if(TARGET fire3dv_scene)
  fire3dv_test(radiance_file_test SOURCES geometry/radiance_file_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(openexr_to_write REQUIRED IMPORTED_TARGET OpenEXR)
  fire3dv_test(openexr_file_test SOURCES textures/openexr_file_test.cpp
               LINK fire3dv_scene fire3dv_test_support PkgConfig::openexr_to_write LABELS unit)
endif()
if(TARGET fire3dv_passes)
  fire3dv_test(material_records_test SOURCES drawing/material_records_test.cpp LINK fire3dv_passes LABELS unit)
endif()

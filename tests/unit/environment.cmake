# Environment images and material records.
if(TARGET fire3dv_scene)
  fire3dv_test(radiance_file_test SOURCES geometry/radiance_file_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit)
endif()
if(TARGET fire3dv_passes)
  fire3dv_test(material_records_test SOURCES drawing/material_records_test.cpp LINK fire3dv_passes LABELS unit)
endif()

if(TARGET fire3dv_mesh_files)
  fire3dv_test(mesh_files_test SOURCES mesh_files_test.cpp
               LINK fire3dv_mesh_files fire3dv_test_support LABELS unit)
endif()

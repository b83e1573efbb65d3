if(TARGET fire3dv_scene)
  fire3dv_test(clusters_test SOURCES clusters_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(caster_shape_test SOURCES caster_shape_test.cpp LINK fire3dv_scene LABELS unit)
endif()

# Clusters, packed vertices, ray boxes, caster shapes.
if(TARGET fire3dv_scene)
  fire3dv_test(cluster_growth_test SOURCES geometry/cluster_growth_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(clusters_test SOURCES geometry/clusters_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(packed_vertices_test SOURCES geometry/packed_vertices_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(ray_boxes_test SOURCES geometry/ray_boxes_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(caster_shape_test SOURCES geometry/caster_shape_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(cluster_levels_test SOURCES geometry/cluster_levels_test.cpp LINK fire3dv_scene LABELS unit)
endif()

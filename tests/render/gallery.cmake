# Scenes of docs/gallery.md.
if(TARGET fire3dv_passes AND TARGET gallery_scenes_library)
  fire3dv_test(render_gallery_test SOURCES assets/gallery_test.cpp
               LINK fire3dv_render_bench fire3dv_scene gallery_scenes_library LABELS render TIMEOUT 900)
endif()

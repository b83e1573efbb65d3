# ImGui panels over the image.
if(TARGET fire3dv_gui)
  fire3dv_test(render_gui_test
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/gui_test.cpp ${PROJECT_SOURCE_DIR}/tools/lab/bench/panel_facts.cpp
    LINK fire3dv_render_bench fire3dv_gui LABELS render TIMEOUT 900)
endif()

# ImGui panels without a GPU.
if(TARGET fire3dv_gui)
  fire3dv_test(gui_test
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/editing/gizmo_test.cpp ${CMAKE_CURRENT_LIST_DIR}/app/gui_panels_test.cpp ${CMAKE_CURRENT_LIST_DIR}/app/gui_layout_test.cpp
            ${CMAKE_CURRENT_LIST_DIR}/app/gui_limits_test.cpp ${CMAKE_CURRENT_LIST_DIR}/app/gui_docks_test.cpp
            ${CMAKE_CURRENT_LIST_DIR}/app/gui_plots_test.cpp ${CMAKE_CURRENT_LIST_DIR}/window/gui_theme_test.cpp
            ${PROJECT_SOURCE_DIR}/tests/render/support/scene_builder.cpp ${PROJECT_SOURCE_DIR}/tools/lab/bench/panel_facts.cpp
    LINK fire3dv_gui LABELS unit)
endif()

# Offline rendering: recorded show, frame folders, video.
if(TARGET fire3dv_recorded)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(libav_to_read REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil libswscale)
  fire3dv_test(offline_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/app/offline_show_test.cpp ${CMAKE_CURRENT_LIST_DIR}/app/offline_folder_test.cpp
               ${CMAKE_CURRENT_LIST_DIR}/sinks/video_test.cpp
               LINK fire3dv_recorded fire3dv_video PkgConfig::libav_to_read LABELS unit)
endif()

# Installation of programs and documents. The client library installs itself (adapters/generic/install.cmake, component
# "client").
#
# RPATH: programs find the library relative to themselves, in any prefix and in the build tree. They are linked with the
# final path: CMake would pad a path for later replacement with colons, whose empty elements mean the current directory.
# Libraries outside the system folders keep their link-time path.
option(FIRE3DV_INSTALL_LAB "Install the programs that measure the project itself" OFF)
set(installed_programs fire3dv fire3dv-convert fire3dv-drake fire3dv-gazebo fire3dv-inspect fire3dv-mujoco fire3dv-record fire3dv-replay fire3dv-ros2 bullet_arm)
set(lab_programs fire3dv-bench fire3dv-contact-sheet fire3dv-impair fire3dv-motion fire3dv-mujoco-compare fire3dv-ros2-bench)
foreach(program ${installed_programs} ${lab_programs})
  if(TARGET ${program})
    file(RELATIVE_PATH lib_from_bin /prefix/${CMAKE_INSTALL_BINDIR} /prefix/${CMAKE_INSTALL_LIBDIR})
    set_target_properties(${program} PROPERTIES
      INSTALL_RPATH "$ORIGIN/${lib_from_bin}" INSTALL_RPATH_USE_LINK_PATH ON BUILD_WITH_INSTALL_RPATH ON)
    if(FIRE3DV_INSTALL_LAB OR program IN_LIST installed_programs)
      install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
    endif()
  endif()
endforeach()
# Desktop entries, file types, AppStream metadata and icons: file managers offer the viewer for files that it opens.
set(desktop ${PROJECT_SOURCE_DIR}/cmake/package/desktop)
set(desktop_types "model/gltf-binary;model/gltf+json;model/obj;model/stl;model/3mf;model/x-ply;model/vnd.collada+xml"
    "application/x-urdf+xml;application/x-xacro+xml;application/x-mjcf+xml")
set(desktop_descriptions "URDF, xacro, MJCF and AMBF")
if(TARGET fire3dv_sdf_reader)
  list(APPEND desktop_types application/x-sdformat+xml)
  set(desktop_descriptions "URDF, xacro, MJCF, AMBF and SDF")
endif()
list(JOIN desktop_types "</mediatype>\n    <mediatype>" appstream_types)
configure_file(${desktop}/fire3dv.desktop.in ${PROJECT_BINARY_DIR}/desktop/fire3dv.desktop @ONLY)
configure_file(${desktop}/org.fire3dv.fire3dv.metainfo.xml.in ${PROJECT_BINARY_DIR}/desktop/org.fire3dv.fire3dv.metainfo.xml @ONLY)
function(fire3dv_install_desktop share)  # ... arguments of install()
  install(FILES ${PROJECT_BINARY_DIR}/desktop/fire3dv.desktop ${desktop}/fire3dv-recording.desktop
          DESTINATION ${share}/applications ${ARGN})
  install(FILES ${PROJECT_BINARY_DIR}/desktop/org.fire3dv.fire3dv.metainfo.xml DESTINATION ${share}/metainfo ${ARGN})
  install(FILES ${desktop}/fire3dv.xml DESTINATION ${share}/mime/packages ${ARGN})
  install(FILES ${desktop}/fire3dv.svg DESTINATION ${share}/icons/hicolor/scalable/apps ${ARGN})
  install(FILES ${desktop}/fire3dv.png DESTINATION ${share}/icons/hicolor/128x128/apps ${ARGN})
endfunction()
# Unit of a user's service manager, which looks in lib/systemd/user of /usr and /usr/local.
function(fire3dv_install_service bin_dir)  # ... arguments of install()
  string(MAKE_C_IDENTIFIER "${bin_dir}" folder)
  set(unit ${PROJECT_BINARY_DIR}/service/${folder}/fire3dv@.service)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/package/service/fire3dv@.service.in ${unit} @ONLY)
  install(FILES ${unit} DESTINATION lib/systemd/user ${ARGN})
endfunction()
fire3dv_install_service(${CMAKE_INSTALL_FULL_BINDIR} COMPONENT programs)
fire3dv_install_desktop(${CMAKE_INSTALL_DATADIR} COMPONENT programs)
install(FILES LICENSE NOTICE README.md CHANGELOG.md protocol/SPEC.md protocol/SPEC-transport.md protocol/SPEC-record.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)

# Programs and papers. The client library installs itself (adapters/generic/install.cmake, component "client").
# Programs find the library beside them, wherever the prefix is moved to, and in the build tree in the same place. They
# are linked with that path at once: a path that CMake replaces at the installation is padded with colons until then, and an
# empty element is the current directory. Libraries that lie outside of the system's folders are found where they were linked.
foreach(program fire3dv fire3dv-bench fire3dv-contact-sheet fire3dv-convert fire3dv-impair fire3dv-inspect fire3dv-motion fire3dv-mujoco fire3dv-mujoco-compare fire3dv-record fire3dv-replay
        bullet_arm)
  if(TARGET ${program})
    file(RELATIVE_PATH lib_from_bin /prefix/${CMAKE_INSTALL_BINDIR} /prefix/${CMAKE_INSTALL_LIBDIR})
    set_target_properties(${program} PROPERTIES
      INSTALL_RPATH "$ORIGIN/${lib_from_bin}" INSTALL_RPATH_USE_LINK_PATH ON BUILD_WITH_INSTALL_RPATH ON)
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
  endif()
endforeach()
install(FILES LICENSE NOTICE README.md CHANGELOG.md protocol/SPEC.md protocol/SPEC-transport.md protocol/SPEC-record.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)

# Installation of the client: headers, library, Python package, CMake package and pkg-config file. The component
# "client" installs alone: cmake --install build/release --component client --prefix DIR
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/fire3dv)

install(TARGETS fire3dv_client EXPORT fire3dv
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT client NAMELINK_COMPONENT client)
install(DIRECTORY python/fire3dv DESTINATION ${CMAKE_INSTALL_DATADIR}/fire3dv/python COMPONENT client
  FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY include/fire3dv DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT client)
install(EXPORT fire3dv NAMESPACE fire3dv:: FILE fire3dv-targets.cmake DESTINATION ${package_dir} COMPONENT client)

configure_package_config_file(cmake/fire3dv-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/fire3dv-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/fire3dv-config-version.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/fire3dv-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/fire3dv-config-version.cmake
  DESTINATION ${package_dir} COMPONENT client)

# The .pc file computes its prefix from its own location, so that the installed tree is relocatable.
file(RELATIVE_PATH prefix_from_pc /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
configure_file(cmake/fire3dv-client.pc.in ${CMAKE_CURRENT_BINARY_DIR}/fire3dv-client.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/fire3dv-client.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT client)

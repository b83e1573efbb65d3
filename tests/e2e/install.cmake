# Client installation: installs into a prefix, moves it, and builds and runs both examples against
# it, with find_package and with pkg-config, as their READMEs describe.
if(TARGET client_c)
  add_test(NAME install_client
    COMMAND ${CMAKE_COMMAND}
      -D BUILD=${PROJECT_BINARY_DIR} -D SOURCE=${PROJECT_SOURCE_DIR} -D LIBDIR=${CMAKE_INSTALL_LIBDIR}
      -D WORK=${CMAKE_CURRENT_BINARY_DIR}/install_client -D GENERATOR=${CMAKE_GENERATOR}
      -D CC=${CMAKE_C_COMPILER} -D CXX=${CMAKE_CXX_COMPILER} -D SANITIZE=${FIRE3DV_SANITIZE}
      -P ${CMAKE_CURRENT_SOURCE_DIR}/scripts/install_client.cmake)
  set_tests_properties(install_client PROPERTIES LABELS "e2e;cpu" TIMEOUT 600)
endif()

# No program or library of the build searches the current directory for libraries.
add_test(NAME run_paths
         COMMAND ${CMAKE_CURRENT_LIST_DIR}/run_paths_test.py --readelf ${CMAKE_READELF} ${PROJECT_BINARY_DIR})
set_tests_properties(run_paths PROPERTIES LABELS "e2e;cpu" TIMEOUT 300)

# What `cmake --install` gives, used from where it was moved to.
if(TARGET fire3dv AND TARGET bullet_arm)
  add_test(NAME test_install COMMAND ${CMAKE_CURRENT_LIST_DIR}/install_test.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
           ${PROJECT_VERSION} $<CONFIG>)
  set_tests_properties(test_install PROPERTIES LABELS e2e TIMEOUT 300)
endif()

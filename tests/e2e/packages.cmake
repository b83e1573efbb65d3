# Debian packages and the wheel of this build, unpacked and used.
find_program(FIRE3DV_DPKG_SHLIBDEPS dpkg-shlibdeps)
find_program(FIRE3DV_FILE file)
find_program(FIRE3DV_MD2MAN go-md2man)  # docs/ is configured later
if(FIRE3DV_DPKG_SHLIBDEPS AND FIRE3DV_FILE AND FIRE3DV_MD2MAN AND TARGET fire3dv AND TARGET bullet_arm AND NOT FIRE3DV_SANITIZE)
  set(packaged_adapters)
  foreach(adapter mujoco drake gazebo ros2)
    if(TARGET fire3dv-${adapter})
      list(APPEND packaged_adapters ${adapter})
    endif()
  endforeach()
  add_test(NAME packages
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/packages_test.py ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
            ${PROJECT_VERSION} ${CMAKE_LIBRARY_ARCHITECTURE} ${packaged_adapters})
  set_tests_properties(packages PROPERTIES LABELS e2e TIMEOUT 600
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
else()
  message(STATUS "The test \"packages\" is left out: it needs dpkg-dev, file, go-md2man, and a build without a sanitizer")
endif()

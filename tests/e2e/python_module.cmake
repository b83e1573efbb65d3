# Python package with the library of this build. A Python interpreter without a sanitizer cannot
# load a library with one.
include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
find_program(FIRE3DV_PYTHON python3)
if(FIRE3DV_PYTHON AND NOT FIRE3DV_SANITIZE)
  function(python_module_case name python)  # ... arguments
    add_test(NAME python_module_${name} COMMAND ${python} ${ARGN})
    set_tests_properties(python_module_${name} PROPERTIES LABELS e2e TIMEOUT 300
      ENVIRONMENT "PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;PYTHONDONTWRITEBYTECODE=1;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endfunction()
  foreach(scheme shm tcp)  # with and without NumPy
    python_module_case(${scheme} ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_module_test.py $<TARGET_FILE:stream_dump> ${scheme})
  endforeach()
  python_module_case(arrays ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_arrays_test.py $<TARGET_FILE:stream_dump>)
  fire3dv_program(e2e_lying_renderer SOURCES programs/lying_renderer.cpp LINK fire3dv_wire fire3dv_transport)
  fire3dv_program(e2e_image_example SOURCES programs/image_example.c LINK fire3dv_client)
  set_target_properties(e2e_lying_renderer e2e_image_example PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  set(lying_renderer_adapter)
  if(TARGET fire3dv-mujoco)
    set(lying_renderer_adapter $<TARGET_FILE:fire3dv-mujoco> ${PROJECT_SOURCE_DIR}/tests/assets/robots/crane.xml)
  endif()
  python_module_case(lying_renderer ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_lying_renderer_test.py
    $<TARGET_FILE:e2e_lying_renderer> $<TARGET_FILE:e2e_image_example> ${lying_renderer_adapter})
  python_module_case(poses ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_poses_test.py)
  python_module_case(show ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_show_test.py)
  python_module_case(types ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_types_test.py)
  python_module_case(demo ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_demo_test.py)
  python_module_case(conformance ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_conformance_test.py
    $<TARGET_FILE:stream_dump> ${PROJECT_SOURCE_DIR}/tests/conformance/data)
  python_module_case(scalars ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_scalars_test.py
    $<TARGET_FILE:fire3dv-inspect> $<TARGET_FILE:fire3dv-record> $<TARGET_FILE:fire3dv-replay> $<TARGET_FILE:stream_dump>)
  set(python_renderer)
  if(TARGET fire3dv)
    set(python_renderer $<TARGET_FILE:fire3dv>)
  endif()
  python_module_case(installed ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_install_test.py
    ${PROJECT_SOURCE_DIR} $<TARGET_FILE:fire3dv_client> ${PROJECT_VERSION} ${python_renderer})
  set_tests_properties(python_module_installed PROPERTIES TIMEOUT 900)
  if(TARGET fire3dv)
    function(python_renderer_case name script)  # ... programs and cases
      python_module_case(${name} ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/${script} ${ARGN})
      set_property(TEST python_module_${name} APPEND PROPERTY ENVIRONMENT
        "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER}" "VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
      set_tests_properties(python_module_${name} PROPERTIES LABELS e2e TIMEOUT 900)
    endfunction()
    python_renderer_case(renderer python_renderer_test.py $<TARGET_FILE:fire3dv>)
    if(TARGET fire3dv-convert)
      python_renderer_case(robot python_robot_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:stream_dump>)
    endif()
    python_renderer_case(images python_images_test.py $<TARGET_FILE:fire3dv>)
    python_renderer_case(batch python_batch_test.py $<TARGET_FILE:fire3dv>)
    python_renderer_case(threads python_threads_test.py $<TARGET_FILE:fire3dv>)
    python_renderer_case(markers python_markers_test.py $<TARGET_FILE:fire3dv>)
    foreach(script markers double_scale controls)
      python_module_case(${script}_window ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/window/${script}_test.py $<TARGET_FILE:fire3dv>)
      set_property(TEST python_module_${script}_window APPEND PROPERTY ENVIRONMENT
        "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER}" "VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
      set_tests_properties(python_module_${script}_window PROPERTIES LABELS e2e TIMEOUT 900)
    endforeach()
    python_renderer_case(sofa python_sofa_test.py $<TARGET_FILE:fire3dv>)
    python_renderer_case(plots python_plots_test.py $<TARGET_FILE:fire3dv>)
    if(TARGET fire3dv-mujoco)  # the converter reads MJCF
      python_renderer_case(mujoco python_mujoco_test.py $<TARGET_FILE:fire3dv>)
    endif()
    if(TARGET fire3dv-convert)
      python_renderer_case(pybullet python_pybullet_test.py $<TARGET_FILE:fire3dv>)
    endif()
  endif()
endif()

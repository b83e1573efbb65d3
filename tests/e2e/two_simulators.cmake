# Example two_simulators: each simulator alone, then both with a renderer, by the commands of its
# README.
if(TARGET two_simulators_heap)
  fire3dv_test(two_simulators_simulation_test
    SOURCES programs/two_simulators_simulation_test.cpp
    LINK two_simulators_heap $<$<TARGET_EXISTS:two_simulators_carousel>:two_simulators_carousel>
    LABELS e2e)
  if(TARGET two_simulators_carousel)
    target_compile_definitions(two_simulators_simulation_test PRIVATE FIRE3DV_HAS_MUJOCO)
  endif()
endif()

if(TARGET fire3dv AND TARGET two_simulators_mujoco)
  foreach(cases shm tcp udp one_twice inspected usage)
    add_test(NAME two_simulators_${cases}
      COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/bullet_arm/two_simulators_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-inspect>
              $<TARGET_FILE:two_simulators_scene> $<TARGET_FILE:two_simulators_bullet> $<TARGET_FILE:two_simulators_mujoco> ${cases})
    set_tests_properties(two_simulators_${cases} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
  endforeach()
  set_tests_properties(two_simulators_shm two_simulators_udp PROPERTIES LABELS long)  # transports are proved elsewhere
endif()

# Import of MuJoCo as the target fire3dv_mujoco, where it is installed. Found by hand, since MuJoCo's CMake package
# contains folders of its build machine.
include_guard(GLOBAL)
find_path(FIRE3DV_MUJOCO_INCLUDE mujoco/mujoco.h)
find_library(FIRE3DV_MUJOCO_LIBRARY mujoco)
if(FIRE3DV_MUJOCO_INCLUDE AND FIRE3DV_MUJOCO_LIBRARY)
  add_library(fire3dv_mujoco INTERFACE)
  target_link_libraries(fire3dv_mujoco INTERFACE ${FIRE3DV_MUJOCO_LIBRARY})
  target_include_directories(fire3dv_mujoco SYSTEM INTERFACE ${FIRE3DV_MUJOCO_INCLUDE})
else()
  message(STATUS "MuJoCo is not installed (libmujoco-dev): fire3dv-mujoco and two_simulators_mujoco are left out")
endif()

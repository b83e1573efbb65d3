# Library fire3dv_build_info: version, commit and optional parts of this build. The commit is that of the last
# configure run, so that a commit alone rebuilds nothing; archives of git have theirs in archive_commit.txt.
# The hash alone: with a tag, the text of a released commit would be the tag's name.
file(READ ${CMAKE_CURRENT_LIST_DIR}/archive_commit.txt archived)
if(archived MATCHES "^([0-9a-f]+) ([0-9]+)")  # the hash, and the time in seconds
  string(SUBSTRING ${CMAKE_MATCH_1} 0 12 fire3dv_commit)
else()
  set(fire3dv_commit "unknown")
endif()
if(EXISTS ${PROJECT_SOURCE_DIR}/.git)  # not that of an outer repository
  execute_process(COMMAND git describe --always --dirty --abbrev=12 --exclude "*" WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE described RESULT_VARIABLE result ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(result EQUAL 0)
    set(fire3dv_commit ${described})
  endif()
endif()
set(fire3dv_features "${CMAKE_BUILD_TYPE}")
foreach(feature fire3dv:renderer fire3dv_adf:AMBF fire3dv_urdf:URDF fire3dv_sdf_reader:SDF fire3dv-mujoco:MJCF fire3dv-drake:Drake fire3dv-ros2:ROS\ 2 fire3dv-gazebo:Gazebo bullet_arm:examples)
  string(REPLACE ":" ";" parts ${feature})
  list(GET parts 0 target)
  list(GET parts 1 text)
  if(TARGET ${target})
    string(APPEND fire3dv_features ", ${text}")
  endif()
endforeach()
if(FIRE3DV_VALIDATION_DEFAULT)
  string(APPEND fire3dv_features ", Vulkan validation by default")
endif()
if(FIRE3DV_SANITIZE)
  string(APPEND fire3dv_features ", sanitizers ${FIRE3DV_SANITIZE}")
endif()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/build_info.cpp @ONLY NEWLINE_STYLE UNIX CONTENT
[[#include "base/build_info.h"

namespace fire3dv {
const char* const kVersion = "@PROJECT_VERSION@";
const char* const kCommit = "@fire3dv_commit@";
const char* const kFeatures = "@fire3dv_features@";
}  // namespace fire3dv
]])
fire3dv_library(fire3dv_build_info SOURCES ${PROJECT_BINARY_DIR}/build_info.cpp)

# Exported symbols of the client library: its C functions only.
# cmake -D NM=nm -D LIBRARY=libfire3dv-client.so -P client_exports.cmake
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${text}")
set(exported)
foreach(line ${lines})
  string(REGEX REPLACE ".* " "" symbol "${line}")
  list(APPEND exported ${symbol})
endforeach()
list(SORT exported)
set(expected fire3dv_add_node fire3dv_cancel_image fire3dv_clear fire3dv_clear_marker
             fire3dv_clear_scalars fire3dv_close fire3dv_close_robot
             fire3dv_declare_scalars fire3dv_describe fire3dv_get_joint fire3dv_get_node_pose fire3dv_get_poses
             fire3dv_get_positions fire3dv_get_robot_description fire3dv_joint_count fire3dv_last_error
             fire3dv_open fire3dv_open_robot fire3dv_poll fire3dv_position_count fire3dv_publish
             fire3dv_publish_robot fire3dv_publish_some fire3dv_read_robot fire3dv_release_image
             fire3dv_remove_node fire3dv_request_image fire3dv_set_base fire3dv_set_base_color
             fire3dv_set_camera fire3dv_set_joint fire3dv_set_joint_scalars fire3dv_set_light fire3dv_set_marker fire3dv_set_positions
             fire3dv_set_scalars fire3dv_set_vertices fire3dv_set_visible fire3dv_version fire3dv_wait_ack fire3dv_wait_image)
if(NOT exported STREQUAL expected)
  message(FATAL_ERROR "${LIBRARY} exports\n  ${exported}\ninstead of\n  ${expected}")
endif()

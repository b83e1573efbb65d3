# cmake -D NM=nm -D LIBRARY=libfire3dv_ambf.so -P ambf_plugin_exports.cmake
# AMBF loads plugins into one space of names: what is exported here would be everybody's.
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${text}")
list(TRANSFORM lines REPLACE ".* " "")
if(NOT lines STREQUAL "CreatePlugin")
  message(FATAL_ERROR "${LIBRARY} exports\n  ${lines}\ninstead of\n  CreatePlugin")
endif()

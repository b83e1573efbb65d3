# Portable copy of the benchmark program with its libraries:
#
#   cmake -DPROGRAM=build/lab/bin/fire3dv-bench -DOUT=folder -P tools/lab/bench/carry.cmake
#
# The script copies the program and its libraries to OUT/bin/fire3dv-bench and OUT/lib, for a machine
# that has only a Vulkan driver. The C library and the driver are that machine's own.
foreach(argument PROGRAM OUT)
  if(NOT ${argument})
    message(FATAL_ERROR "carry.cmake: say -DPROGRAM=FILE -DOUT=FOLDER before -P")
  endif()
endforeach()
file(REAL_PATH ${PROGRAM} program BASE_DIRECTORY ${CMAKE_SOURCE_DIR})
if(NOT EXISTS ${program})
  message(FATAL_ERROR "carry.cmake: ${program} is not there; build fire3dv-bench first")
endif()
file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${program} RESOLVED_DEPENDENCIES_VAR libraries
     PRE_EXCLUDE_REGEXES "^ld-linux" "^lib(c|m|dl|rt|pthread)\\.so")
file(COPY ${program} DESTINATION ${OUT}/bin)
file(COPY ${libraries} DESTINATION ${OUT}/lib FOLLOW_SYMLINK_CHAIN)
get_filename_component(name ${program} NAME)
find_program(strip strip)
if(strip)
  execute_process(COMMAND ${strip} --strip-unneeded ${OUT}/bin/${name})
endif()

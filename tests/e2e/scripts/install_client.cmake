# Client installation test; see tests/e2e/install.cmake.
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "failed (${code}): ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(publish_100_frames program name)
  string(RANDOM LENGTH 8 suffix)
  run(${program} shm://install-${suffix} 100)
  if(NOT output STREQUAL "${name}: 100 frames published\n")
    message(FATAL_ERROR "${program} said: ${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --component client --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/prefix)  # an installed tree is relocatable
set(prefix ${WORK}/prefix)

foreach(path include/fire3dv/client.h include/fire3dv/client.hpp ${LIBDIR}/libfire3dv-client.so
             ${LIBDIR}/cmake/fire3dv/fire3dv-config.cmake ${LIBDIR}/pkgconfig/fire3dv-client.pc)
  if(NOT EXISTS ${prefix}/${path})
    message(FATAL_ERROR "${path} was not installed")
  endif()
endforeach()

# The installed text files must not contain paths of the build or the source tree.
file(GLOB_RECURSE texts ${prefix}/*.cmake ${prefix}/*.pc ${prefix}/*.h ${prefix}/*.hpp)
foreach(text ${texts})
  file(READ ${text} content)
  foreach(path ${BUILD} ${SOURCE})
    string(FIND "${content}" "${path}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${text} holds the path ${path}")
    endif()
  endforeach()
endforeach()

set(sanitize_flags)
if(SANITIZE)
  set(sanitize_flags -fsanitize=${SANITIZE})  # the program must link the sanitizer runtime of the library
endif()

foreach(example client_c client_cpp)
  run(${CMAKE_COMMAND} -S ${SOURCE}/examples/${example} -B ${WORK}/${example} -G ${GENERATOR}
      -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_C_COMPILER=${CC} -D CMAKE_CXX_COMPILER=${CXX}
      "-DCMAKE_EXE_LINKER_FLAGS=${sanitize_flags}")
  run(${CMAKE_COMMAND} --build ${WORK}/${example})
  publish_100_frames(${WORK}/${example}/${example} ${example})
endforeach()

set(ENV{PKG_CONFIG_PATH} ${prefix}/${LIBDIR}/pkgconfig)
run(pkg-config --cflags --libs fire3dv-client)
string(STRIP "${output}" flags)
separate_arguments(flags UNIX_COMMAND "${flags}")
set(flags ${flags} ${sanitize_flags} -Wl,-rpath,${prefix}/${LIBDIR})
run(${CC} -std=c11 -Wall -Wextra -Wpedantic -Werror ${SOURCE}/examples/client_c/main.c -o ${WORK}/pc_c ${flags} -lm)
run(${CXX} -std=c++17 -Wall -Wextra -Wpedantic -Werror ${SOURCE}/examples/client_cpp/main.cpp -o ${WORK}/pc_cpp ${flags})
publish_100_frames(${WORK}/pc_c client_c)
publish_100_frames(${WORK}/pc_cpp client_cpp)

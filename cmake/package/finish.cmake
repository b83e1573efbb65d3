# Last step before CPack writes the packages, on its staging folders: no RUNPATH, the static library, compressed documents,
# completions. CPack includes it with its own variables.
set(stage ${CPACK_TEMPORARY_INSTALL_DIRECTORY})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "packages: ${ARGN} failed (${result}): ${output}")
  endif()
endfunction()

# Programs find the client library in the system's own folders.
file(GLOB programs ${stage}/*/usr/bin/*)
if(NOT programs)
  message(FATAL_ERROR "packages: ${stage} holds no programs")
endif()
foreach(program ${programs})
  file(RPATH_REMOVE FILE ${program})
endforeach()

file(GLOB dev_folder ${stage}/package_libfire3dv-client-dev/usr/lib/*/cmake)
get_filename_component(dev_folder ${dev_folder} DIRECTORY)
execute_process(COMMAND ar -M INPUT_FILE ${CPACK_FIRE3DV_STATIC_LIBRARY} WORKING_DIRECTORY ${dev_folder}
                RESULT_VARIABLE result ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "packages: the static library cannot be written (ar: ${output}): build all targets first")
endif()
run(strip --strip-debug --remove-section=.comment --enable-deterministic-archives ${dev_folder}/libfire3dv-client.a)

# Completions from the help of these very programs.
file(GLOB folders ${stage}/package_fire3dv ${stage}/package_fire3dv-*)
foreach(folder ${folders})
  file(GLOB programs ${folder}/usr/bin/*)
  list(TRANSFORM programs REPLACE "/fire3dv$" "/fire3dv:render:dataset:relabel:join:verify:doctor")
  if(programs)
    set(share ${folder}/usr/share)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS}
      python3 ${CPACK_FIRE3DV_SOURCE_DIR}/tools/completions.py --bash ${share}/bash-completion/completions
      --zsh ${share}/zsh/vendor-completions --fish ${share}/fish/vendor_completions.d ${programs}
      RESULT_VARIABLE result ERROR_VARIABLE output)
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "packages: no completions: ${output}")
    endif()
  endif()
endforeach()

file(GLOB documents ${stage}/*/usr/share/man/man1/*.1 ${stage}/*/usr/share/doc/*/changelog*)
foreach(document ${documents})
  run(gzip -9n ${document})
endforeach()

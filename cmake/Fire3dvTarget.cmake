# Target functions of the project:
#
#   fire3dv_library(name SOURCES ... [LINK ...])   static library, one per layer
#   fire3dv_program(name SOURCES ... [LINK ...])   program in build/<preset>/bin
#
# Both apply the project's warnings and the selected sanitizers. Include paths start at the source tree, so that an
# #include names its layer.

add_library(fire3dv_flags INTERFACE)
# Vulkan structures are initialised as {VK_STRUCTURE_TYPE_X}; all other members are zero on purpose.
target_compile_options(fire3dv_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wno-missing-field-initializers
                       $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual>)
# Assertion messages contain paths relative to the source tree, so that binaries do not reveal the build machine's
# paths.
target_compile_options(fire3dv_flags INTERFACE $<$<NOT:$<CONFIG:Debug>>:-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=>)
# g++ 12 to 14 report false overlaps, overflows and bounds in std::string and std::vector at -O2 and -O3 (GCC bug 105651
# and similar). Debug builds keep these warnings, and sanitizers detect real errors.
foreach(warning restrict stringop-overflow stringop-overread array-bounds)
  target_compile_options(fire3dv_flags INTERFACE
    $<$<AND:$<NOT:$<CONFIG:Debug>>,$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,15>>:-Wno-${warning}>)
endforeach()
if(FIRE3DV_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15)
  # Sanitizer instrumentation hides initialisations from these warnings (std::regex, std::optional). These builds are
  # also optimised slightly.
  target_compile_options(fire3dv_flags INTERFACE -Wno-maybe-uninitialized $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>
                         -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds)
endif()
if(FIRE3DV_WERROR)
  target_compile_options(fire3dv_flags INTERFACE -Werror)
endif()
if(FIRE3DV_SANITIZE)
  target_compile_options(fire3dv_flags INTERFACE -fsanitize=${FIRE3DV_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(fire3dv_flags INTERFACE -fsanitize=${FIRE3DV_SANITIZE})
endif()
target_include_directories(fire3dv_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})

# Unity builds compile several sources of a target as one, so that their headers are parsed once. A whole build takes half
# of the time; a change of one file, a little longer. Names in anonymous namespaces are therefore unique within a target.
option(FIRE3DV_UNITY "Compile several sources of a target at once: whole builds are quicker" OFF)
set(FIRE3DV_UNITY_SOURCES 8 CACHE STRING "Sources that a unity build compiles at once")
mark_as_advanced(FIRE3DV_UNITY_SOURCES)
if(FIRE3DV_UNITY)
  # g++ takes a .cpp file that a unity source includes for a header, whose classes should not use anonymous namespaces.
  # Local names may be those of another file.
  target_compile_options(fire3dv_flags INTERFACE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:SHELL:-Wno-subobject-linkage -Wno-shadow -Wshadow=local>")
endif()
function(fire3dv_unity name)
  if(FIRE3DV_UNITY)
    set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${FIRE3DV_UNITY_SOURCES})
  endif()
endfunction()

function(fire3dv_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  fire3dv_unity(${name})
  target_link_libraries(${name} PUBLIC fire3dv_flags ${arg_LINK})
endfunction()

function(fire3dv_program name)
  cmake_parse_arguments(arg "TEST" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  fire3dv_unity(${name})
  target_link_libraries(${name} PRIVATE fire3dv_flags ${arg_LINK})
  if(NOT arg_TEST)
    target_link_libraries(${name} PRIVATE fire3dv_build_info)  # for --version
  endif()
endfunction()

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

# Parsing the standard library takes a third of a full build. Precompiled headers pay off for full builds (the CI
# presets); otherwise they only defeat compiler caches. Every file still includes what it uses. GCC accepts a
# precompiled header only with identical options, hence one set for libraries (-fPIC), programs (-fPIE) and tests.
option(FIRE3DV_PRECOMPILE "Precompile the standard library's headers: whole builds are quicker" OFF)
set(fire3dv_common_headers algorithm array atomic bit charconv chrono cmath cstdint cstring deque filesystem fstream functional
    iostream limits map memory mutex numbers numeric optional random set span sstream string string_view thread tuple
    unordered_map utility variant vector glm/glm.hpp)
function(fire3dv_precompiled name)
  cmake_parse_arguments(arg "" "" "HEADERS;OPTIONS;LINK" ${ARGN})
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled/${name}.cpp CONTENT "// What is wanted of it is its headers.\n")
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/precompiled/${name}.cpp)
  target_link_libraries(${name} PRIVATE fire3dv_flags ${arg_LINK})
  target_compile_options(${name} PRIVATE ${arg_OPTIONS})
  list(TRANSFORM arg_HEADERS REPLACE "(.+)" "$<$<COMPILE_LANGUAGE:CXX>:<\\1>>")
  target_precompile_headers(${name} PRIVATE ${arg_HEADERS})
  set_target_properties(${name} PROPERTIES PCH_WARN_INVALID OFF)  # targets with other definitions compile without it
endfunction()
function(fire3dv_reuse_precompiled name set)
  if(TARGET ${set})
    target_precompile_headers(${name} REUSE_FROM ${set})
    set_target_properties(${name} PROPERTIES PCH_WARN_INVALID OFF)
  endif()
endfunction()
if(FIRE3DV_PRECOMPILE)
  # A precompiled header alone exceeds the heap size from which g++ collects garbage, which then takes a tenth of the
  # time. Unit: KiB.
  target_compile_options(fire3dv_flags INTERFACE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:SHELL:--param ggc-min-heapsize=600000>")
  # Threads::Threads adds this option, which defines a macro: headers compiled without it are refused.
  target_compile_options(fire3dv_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-pthread>)
  fire3dv_precompiled(fire3dv_library_headers HEADERS ${fire3dv_common_headers})
  fire3dv_precompiled(fire3dv_program_headers HEADERS ${fire3dv_common_headers} OPTIONS $<$<COMPILE_LANGUAGE:CXX>:-fPIE>)
  set_target_properties(fire3dv_program_headers PROPERTIES POSITION_INDEPENDENT_CODE OFF)
endif()

function(fire3dv_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC fire3dv_flags ${arg_LINK})
  fire3dv_reuse_precompiled(${name} fire3dv_library_headers)
endfunction()

function(fire3dv_program name)
  cmake_parse_arguments(arg "" "PRECOMPILED" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE fire3dv_flags ${arg_LINK})
  if(NOT arg_PRECOMPILED)
    target_link_libraries(${name} PRIVATE fire3dv_build_info)  # for --version; not in tests
    set(arg_PRECOMPILED fire3dv_program_headers)
  endif()
  fire3dv_reuse_precompiled(${name} ${arg_PRECOMPILED})
endfunction()

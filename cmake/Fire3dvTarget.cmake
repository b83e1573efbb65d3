# fire3dv_library(name SOURCES ... [LINK ...])   a static library, one per layer of the house
# fire3dv_program(name SOURCES ... [LINK ...])   a program, into build/<preset>/bin
# Both carry the project's warnings and the chosen sanitizers. Includes are rooted at the source tree, so that an
# #include names the layer it reaches into.

add_library(fire3dv_flags INTERFACE)
# Vulkan's structures are made as {VK_STRUCTURE_TYPE_X}: the rest is meant to be zero.
target_compile_options(fire3dv_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wno-missing-field-initializers
                       $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual>)
# Messages name a source file as it lies in the tree: what is shipped knows no path of the machine that built it.
target_compile_options(fire3dv_flags INTERFACE $<$<NOT:$<CONFIG:Debug>>:-fmacro-prefix-map=${PROJECT_SOURCE_DIR}/=>)
# g++ 12 to 14 report overlaps, overflows and bounds in std::string and std::vector at -O2 and -O3 where there are none (GCC bug
# 105651 and similar). Debug builds keep these warnings, and sanitizers look for the real ones.
foreach(warning restrict stringop-overflow stringop-overread array-bounds)
  target_compile_options(fire3dv_flags INTERFACE
    $<$<AND:$<NOT:$<CONFIG:Debug>>,$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,15>>:-Wno-${warning}>)
endforeach()
if(FIRE3DV_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15)
  # Sanitizers insert code that hides initialisations from these warnings (std::regex, std::optional); and these
  # builds are optimised a little, too.
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

# Parsing the standard library is a third of a whole build's time. It is precompiled where a tree is built in one go (the
# presets for CI); elsewhere it would only defeat compiler caches. Every file still includes what it uses. gcc takes such a
# header only where options are the same: one set for libraries (-fPIC), one for programs (-fPIE), one for tests.
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
  set_target_properties(${name} PROPERTIES PCH_WARN_INVALID OFF)  # a target with other definitions does without
endfunction()
function(fire3dv_reuse_precompiled name set)
  if(TARGET ${set})
    target_precompile_headers(${name} REUSE_FROM ${set})
    set_target_properties(${name} PROPERTIES PCH_WARN_INVALID OFF)
  endif()
endfunction()
if(FIRE3DV_PRECOMPILE)
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
    set(arg_PRECOMPILED fire3dv_program_headers)
  endif()
  fire3dv_reuse_precompiled(${name} ${arg_PRECOMPILED})
endfunction()

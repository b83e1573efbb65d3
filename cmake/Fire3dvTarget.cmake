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
# g++ 12 sees overlaps and overflows in std::string and std::vector at -O3 where there are none (GCC bug 105651 and its
# kin, fixed in 13). Debug builds keep these warnings, and sanitizers look for the real ones.
foreach(warning restrict stringop-overflow stringop-overread array-bounds)
  target_compile_options(fire3dv_flags INTERFACE
    $<$<AND:$<NOT:$<CONFIG:Debug>>,$<COMPILE_LANG_AND_ID:CXX,GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-${warning}>)
endforeach()
if(FIRE3DV_WERROR)
  target_compile_options(fire3dv_flags INTERFACE -Werror)
endif()
if(FIRE3DV_SANITIZE)
  target_compile_options(fire3dv_flags INTERFACE -fsanitize=${FIRE3DV_SANITIZE} -fno-omit-frame-pointer
                         -fno-sanitize-recover=all)
  target_link_options(fire3dv_flags INTERFACE -fsanitize=${FIRE3DV_SANITIZE})
endif()
target_include_directories(fire3dv_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})

function(fire3dv_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC fire3dv_flags ${arg_LINK})
endfunction()

function(fire3dv_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE fire3dv_flags ${arg_LINK})
endfunction()

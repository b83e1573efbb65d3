# Every header stands alone: it is compiled by itself, twice in one file. Those that simulators include are compiled as
# strict C11, C++11 (client.h) and C++17, without any of the project's own include paths.
set(header_dir ${CMAKE_CURRENT_BINARY_DIR}/headers)
function(header_source result header extension)
  string(MAKE_C_IDENTIFIER ${header} id)
  set(path ${header_dir}/${id}.${extension})
  file(CONFIGURE OUTPUT ${path}
       CONTENT "#include \"@header@\"\n#include \"@header@\"\nextern int header_is_complete_@id@;\nint header_is_complete_@id@ = 1;\n" @ONLY)
  set(${result} ${path} PARENT_SCOPE)
endfunction()

set(client_include ${PROJECT_SOURCE_DIR}/adapters/generic/include)
function(public_header_test name header extension)
  header_source(source ${header} ${extension})
  set(copy ${header_dir}/${name}.${extension})
  configure_file(${source} ${copy} COPYONLY)
  add_library(${name} OBJECT ${copy})
  target_include_directories(${name} PRIVATE ${client_include})
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror)
  set_target_properties(${name} PROPERTIES C_STANDARD 11 C_EXTENSIONS OFF CXX_EXTENSIONS OFF)
endfunction()
public_header_test(header_client_h_as_c11 fire3dv/client.h c)
public_header_test(header_client_h_as_cpp11 fire3dv/client.h cpp)
set_target_properties(header_client_h_as_cpp11 PROPERTIES CXX_STANDARD 11)
public_header_test(header_scene_h_as_c11 fire3dv/scene.h c)
public_header_test(header_image_h_as_c11 fire3dv/image.h c)
public_header_test(header_client_hpp_as_cpp17 fire3dv/client.hpp cpp)
set_target_properties(header_client_hpp_as_cpp17 PROPERTIES CXX_STANDARD 17)

file(GLOB_RECURSE protocol_headers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/protocol/*.h)
set(header_sources)
foreach(header ${protocol_headers})
  header_source(source ${header} cpp)
  list(APPEND header_sources ${source})
endforeach()
add_library(protocol_headers OBJECT ${header_sources})
target_link_libraries(protocol_headers PRIVATE fire3dv_flags)

# The compiling is the test; CTest repeats it so that a list of results shows it.
add_test(NAME headers_stand_alone
  COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR} --target header_client_h_as_c11 header_client_h_as_cpp11 header_scene_h_as_c11 header_image_h_as_c11
          header_client_hpp_as_cpp17 protocol_headers)
set_tests_properties(headers_stand_alone PROPERTIES LABELS unit TIMEOUT 600 RUN_SERIAL ON)

# Self-contained headers: each one compiles alone, included twice. Public client headers compile as
# strict C11, C++11 (client.h) and C++17, without the project's include paths.
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
public_header_test(header_markers_h_as_c11 fire3dv/markers.h c)
public_header_test(header_scalars_h_as_c11 fire3dv/scalars.h c)
public_header_test(header_input_h_as_c11 fire3dv/input.h c)
public_header_test(header_joints_h_as_c11 fire3dv/joints.h c)
public_header_test(header_client_hpp_as_cpp17 fire3dv/client.hpp cpp)
set_target_properties(header_client_hpp_as_cpp17 PROPERTIES CXX_STANDARD 17)
public_header_test(header_joints_hpp_as_cpp17 fire3dv/joints.hpp cpp)
set_target_properties(header_joints_hpp_as_cpp17 PROPERTIES CXX_STANDARD 17)

# A header that its own source file includes first compiles alone there. check_tree.py lists the others; outside of a git
# checkout all headers of protocol/ take their place.
execute_process(COMMAND python3 ${PROJECT_SOURCE_DIR}/tools/check_tree.py --lone-headers
                OUTPUT_VARIABLE lone_headers OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE not_listed)
if(not_listed OR NOT TARGET fire3dv_app)
  file(GLOB_RECURSE lone_headers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/protocol/*.h)
else()
  string(REPLACE "\n" ";" lone_headers "${lone_headers}")
endif()
list(FILTER lone_headers EXCLUDE REGEX "^convert/sdf/library/")  # libsdformat's include folders are its own
list(FILTER lone_headers EXCLUDE REGEX "^protocol/(record/foxglove_encoding|wire/encode_tables).h$")  # flatc's headers are private there
set(header_sources)
foreach(header ${lone_headers})
  header_source(source ${header} cpp)
  list(APPEND header_sources ${source})
endforeach()
add_library(lone_headers OBJECT ${header_sources})
target_link_libraries(lone_headers PRIVATE fire3dv_flags $<TARGET_NAME_IF_EXISTS:fire3dv_app>)

# Compilation is the test; the CTest entry repeats it for the list of results.
add_test(NAME headers_stand_alone
  COMMAND ${CMAKE_COMMAND} --build ${PROJECT_BINARY_DIR} --target header_client_h_as_c11 header_client_h_as_cpp11 header_scene_h_as_c11 header_image_h_as_c11 header_markers_h_as_c11 header_scalars_h_as_c11 header_input_h_as_c11 header_joints_h_as_c11
          header_client_hpp_as_cpp17 header_joints_hpp_as_cpp17 lone_headers)
set_tests_properties(headers_stand_alone PROPERTIES LABELS unit TIMEOUT 600 RUN_SERIAL ON)

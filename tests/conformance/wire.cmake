# Golden messages. The generator is built with the tests so that it keeps compiling; run it by hand.
set(later_schema ${CMAKE_CURRENT_SOURCE_DIR}/later.fbs)
set(later_dir ${CMAKE_CURRENT_BINARY_DIR}/generated)
find_program(FIRE3DV_FLATC flatc REQUIRED)
add_custom_command(
  OUTPUT ${later_dir}/later_generated.h
  COMMAND ${FIRE3DV_FLATC} --cpp --scoped-enums -o ${later_dir} ${later_schema}
  DEPENDS ${later_schema}
  VERBATIM)
fire3dv_program(conformance_generate
  SOURCES generate.cpp cases.cpp edit_cases.cpp image_cases.cpp input_cases.cpp json_edit.cpp json_image.cpp json_message.cpp scalar_cases.cpp
  ${later_dir}/later_generated.h LINK fire3dv_wire)
target_include_directories(conformance_generate SYSTEM PRIVATE ${later_dir})
set_target_properties(conformance_generate PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)

fire3dv_test(conformance_test SOURCES conformance_test.cpp json_edit.cpp json_image.cpp json_message.cpp LINK fire3dv_wire LABELS conformance cpu)
target_compile_definitions(conformance_test PRIVATE FIRE3DV_CONFORMANCE_DATA="${CMAKE_CURRENT_SOURCE_DIR}/data")

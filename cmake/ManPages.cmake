# Manual pages from docs/man/*.md. Installed with the programs that they describe.
find_program(FIRE3DV_MD2MAN go-md2man)
if(NOT FIRE3DV_MD2MAN)
  message(STATUS "Manual pages are left out: go-md2man is not installed")
  return()
endif()
file(GLOB manual_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/man/*.1.md)
set(manual_pages)
foreach(source ${manual_sources})
  get_filename_component(page ${source} NAME_WLE)
  set(output ${PROJECT_BINARY_DIR}/man/${page})
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
    COMMAND ${FIRE3DV_MD2MAN} -in ${source} -out ${output}
    DEPENDS ${source}
    COMMENT "Manual page ${page}"
    VERBATIM)
  list(APPEND manual_pages ${output})
  string(REGEX REPLACE "\\.1$" "" program ${page})
  if(FIRE3DV_INSTALL_LAB OR NOT program IN_LIST lab_programs)
    install(FILES ${output} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT programs)
  endif()
endforeach()
add_custom_target(fire3dv_manual_pages ALL DEPENDS ${manual_pages})

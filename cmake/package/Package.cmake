# Debian packages by CPack (tools/package.sh). Components of their own: the paths of Debian (lib/MULTIARCH, the system's
# Python folder) do not depend on how this build installs otherwise. `cmake --install` without a component leaves them out.
if(NOT CMAKE_LIBRARY_ARCHITECTURE OR NOT TARGET fire3dv OR CMAKE_VERSION VERSION_LESS 3.23)
  return()
endif()
set(package_dir ${CMAKE_CURRENT_LIST_DIR})
set(libdir lib/${CMAKE_LIBRARY_ARCHITECTURE})
set(FIRE3DV_PACKAGE_MAINTAINER "The FIRE-3DV authors <fire3dv@example.org>" CACHE STRING
    "Maintainer of the Debian packages: name and e-mail address of who builds and distributes them")

# Distribution: a part of the version, so that an upgrade of Debian also upgrades these packages.
set(distribution "unknown")
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release release REGEX "^(ID|VERSION_ID)=")
  string(REGEX REPLACE ".*VERSION_ID=\"?([0-9.]+).*" "\\1" distribution_version "${release}")
  string(REGEX REPLACE "^(.*;)?ID=\"?([a-z]+).*" "\\2" distribution_id "${release}")
  string(REPLACE "debian" "deb" distribution "${distribution_id}${distribution_version}")
endif()
# Before a release, the commit's time is a part, too: apt installs a newer build over an older one. 1.2.3~git... < 1.2.3.
set(snapshot)
if(EXISTS ${PROJECT_SOURCE_DIR}/.git)
  foreach(variable_and_arguments "release_tag;tag;--points-at;HEAD;--list;v${PROJECT_VERSION}"
          "snapshot;log;-1;--format=~git%cd;--date=format-local:%Y%m%d.%H%M" "package_date;log;-1;--format=%cd;--date=rfc")
    list(POP_FRONT variable_and_arguments variable)
    execute_process(COMMAND ${CMAKE_COMMAND} -E env TZ=UTC git ${variable_and_arguments} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                    OUTPUT_VARIABLE ${variable} OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  endforeach()
  if(release_tag)
    set(snapshot)
  endif()
endif()
set(package_version ${PROJECT_VERSION}${snapshot}-1+${distribution})
if(NOT package_date)
  file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/archive_commit.txt archived REGEX "^[0-9a-f]+ [0-9]+$")
  if(archived AND NOT DEFINED ENV{SOURCE_DATE_EPOCH})
    string(REGEX REPLACE ".* " "" archived_s ${archived})
    set(ENV{SOURCE_DATE_EPOCH} ${archived_s})
  endif()
  string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fire3dv)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VENDOR "The FIRE-3DV authors")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PRE_BUILD_SCRIPTS ${package_dir}/finish.cmake)
set(CPACK_FIRE3DV_SOURCE_DIR ${PROJECT_SOURCE_DIR})
set(CPACK_FIRE3DV_STATIC_LIBRARY ${PROJECT_BINARY_DIR}/package/static_library.mri)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${FIRE3DV_PACKAGE_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_VERSION ${package_version})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})
set(CPACK_COMPONENTS_ALL)

# fire3dv_package(NAME SECTION section DESCRIPTION text [control fields as for CPACK_DEBIAN_COMPONENT_PACKAGE_*]): a package
# with its copyright, changelog and overrides of lintian. Files come from install(... COMPONENT package_NAME EXCLUDE_FROM_ALL).
macro(fire3dv_package name)
  cmake_parse_arguments(arg "" "SECTION;DESCRIPTION;DEPENDS;RECOMMENDS;SUGGESTS;ARCHITECTURE" "CONTROL_EXTRA" ${ARGN})
  set(component package_${name})
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  foreach(field SECTION DEPENDS RECOMMENDS SUGGESTS ARCHITECTURE CONTROL_EXTRA)
    if(arg_${field})
      set(CPACK_DEBIAN_${upper}_PACKAGE_${field} "${arg_${field}}")
    endif()
  endforeach()
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${arg_DESCRIPTION}")
  set(package_name ${name})
  configure_file(${package_dir}/changelog.in ${PROJECT_BINARY_DIR}/package/${name}/changelog.Debian @ONLY)
  install(FILES ${package_dir}/copyright ${PROJECT_BINARY_DIR}/package/${name}/changelog.Debian
          DESTINATION share/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
  if(EXISTS ${package_dir}/lintian/${name})  # warnings of lintian that are right as they are, with reasons
    install(FILES ${package_dir}/lintian/${name} DESTINATION share/lintian/overrides COMPONENT ${component} EXCLUDE_FROM_ALL)
  endif()
endmacro()
function(fire3dv_package_programs name)  # ... programs, with their manual pages
  foreach(program ${ARGN})
    if(TARGET ${program})
      install(TARGETS ${program} RUNTIME DESTINATION bin COMPONENT package_${name} EXCLUDE_FROM_ALL)
    endif()
    install(FILES ${PROJECT_BINARY_DIR}/man/${program}.1 DESTINATION share/man/man1 COMPONENT package_${name} EXCLUDE_FROM_ALL)
  endforeach()
endfunction()

# libav is loaded when a video is made (renderer/sinks/video/libav.cpp), which dpkg-shlibdeps cannot see.
set(recommended "mesa-vulkan-drivers | vulkan-icd")
find_package(PkgConfig REQUIRED)
pkg_check_modules(package_libav QUIET libavformat libavcodec libavutil libswscale)
foreach(library libavcodec libavformat libavutil libswscale)
  string(REGEX MATCH "^[0-9]+" major "${package_libav_${library}_VERSION}")
  string(APPEND recommended ", ${library}${major}")
endforeach()
include(${PROJECT_SOURCE_DIR}/cmake/Hdf5.cmake)
if(FIRE3DV_HDF5_PACKAGE)
  set(suggested_hdf5 ", ${FIRE3DV_HDF5_PACKAGE}")
endif()
set(vulkan_loader "libvulkan1 (>= 1.3)")  # loaded when a program starts
fire3dv_package(fire3dv SECTION graphics DEPENDS "${vulkan_loader}" RECOMMENDS "${recommended}"
  SUGGESTS "fire3dv-drake, fire3dv-examples, fire3dv-gazebo, fire3dv-mujoco, fire3dv-ros2, python3-fire3dv${suggested_hdf5}"
  DESCRIPTION "networked Vulkan renderer for simulators
A simulator publishes poses from its own process; FIRE-3DV draws them in
another one, on the same machine or over a network. The simulator never
waits, and every image says which simulation step it shows.

This package contains the renderer, and programs that inspect, record and
replay streams and convert URDF, SDF, MJCF and AMBF files to glTF.")
fire3dv_package_programs(fire3dv fire3dv fire3dv-convert fire3dv-inspect fire3dv-record fire3dv-replay fire3dv-render
                         fire3dv-doctor fire3dv-dataset fire3dv-relabel fire3dv-verify)
fire3dv_install_desktop(share COMPONENT package_fire3dv EXCLUDE_FROM_ALL)
fire3dv_install_service(/usr/bin COMPONENT package_fire3dv EXCLUDE_FROM_ALL)
install(FILES CHANGELOG.md DESTINATION share/doc/fire3dv RENAME changelog COMPONENT package_fire3dv EXCLUDE_FROM_ALL)
install(FILES NOTICE README.md protocol/SPEC.md protocol/SPEC-transport.md protocol/SPEC-record.md
        DESTINATION share/doc/fire3dv COMPONENT package_fire3dv EXCLUDE_FROM_ALL)
file(GLOB pages CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.md)  # manual pages and README.md refer to them
install(FILES ${pages} DESTINATION share/doc/fire3dv/docs COMPONENT package_fire3dv EXCLUDE_FROM_ALL)

set(own_library "libfire3dv-client${PROJECT_VERSION_MAJOR}")
if(TARGET bullet_arm)
  fire3dv_package(fire3dv-examples SECTION graphics DEPENDS "${own_library} (= ${package_version})" RECOMMENDS fire3dv
    DESCRIPTION "example simulator for the renderer FIRE-3DV
A robot arm, simulated with Bullet Physics, that publishes its poses to
FIRE-3DV renderers.")
  fire3dv_package_programs(fire3dv-examples bullet_arm)
endif()
if(TARGET fire3dv-mujoco)
  fire3dv_package(fire3dv-mujoco SECTION science DEPENDS "${own_library} (= ${package_version})" RECOMMENDS fire3dv
    DESCRIPTION "MuJoCo simulations for the renderer FIRE-3DV
Steps a MuJoCo model and publishes its poses to FIRE-3DV renderers.")
  fire3dv_package_programs(fire3dv-mujoco fire3dv-mujoco)
endif()
if(TARGET fire3dv-drake)
  fire3dv_package(fire3dv-drake SECTION science DEPENDS "${vulkan_loader}" RECOMMENDS "${recommended}, fire3dv"
    DESCRIPTION "Drake render server of the renderer FIRE-3DV
Serves Drake's glTF render client over HTTP: camera images of a Drake
simulation, drawn by FIRE-3DV.")
  fire3dv_package_programs(fire3dv-drake fire3dv-drake)
endif()
if(TARGET fire3dv-gazebo)
  fire3dv_package(fire3dv-gazebo SECTION science DEPENDS "${own_library} (= ${package_version})" RECOMMENDS fire3dv
    DESCRIPTION "Gazebo worlds for the renderer FIRE-3DV
Follows a running Gazebo world, from Fortress to Jetty, and publishes its
scene and poses to FIRE-3DV renderers.")
  fire3dv_package_programs(fire3dv-gazebo fire3dv-gazebo)
endif()
if(TARGET fire3dv-ros2)
  fire3dv_package(fire3dv-ros2 SECTION science DEPENDS "${own_library} (= ${package_version})" RECOMMENDS fire3dv
    DESCRIPTION "ROS 2 adapter of the renderer FIRE-3DV
Publishes the transforms and the robot description of a ROS 2 system to
FIRE-3DV renderers. It needs no ROS installation.")
  fire3dv_package_programs(fire3dv-ros2 fire3dv-ros2)
endif()

# Client library.
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/package/shlibs @ONLY NEWLINE_STYLE UNIX
     CONTENT "libfire3dv-client @PROJECT_VERSION_MAJOR@ @own_library@ (>= @PROJECT_VERSION@~)\n")
fire3dv_package(${own_library} SECTION libs CONTROL_EXTRA ${package_dir}/triggers ${PROJECT_BINARY_DIR}/package/shlibs
  DESCRIPTION "client library of the renderer FIRE-3DV
Publishes the poses of a simulation, and edits of its scene, to FIRE-3DV
renderers, and receives their images. It needs no Vulkan.")
fire3dv_package(libfire3dv-client-dev SECTION libdevel DEPENDS "${own_library} (= ${package_version})"
  SUGGESTS "libsodium-dev, libssl-dev"
  DESCRIPTION "client library of the renderer FIRE-3DV (development files)
Headers for C and C++, CMake package, pkg-config file, and the shared and
static library that publish the poses of a simulation to FIRE-3DV renderers.

The static library needs libssl-dev and libsodium-dev.")
set(dev package_libfire3dv-client-dev)
install(TARGETS fire3dv_client EXPORT fire3dv_package LIBRARY DESTINATION ${libdir} COMPONENT package_${own_library} EXCLUDE_FROM_ALL
        NAMELINK_COMPONENT ${dev})
install(DIRECTORY adapters/generic/include/fire3dv DESTINATION include COMPONENT ${dev} EXCLUDE_FROM_ALL)
install(EXPORT fire3dv_package NAMESPACE fire3dv:: FILE fire3dv-targets.cmake DESTINATION ${libdir}/cmake/fire3dv
        COMPONENT ${dev} EXCLUDE_FROM_ALL)
install(DIRECTORY examples/client_c examples/client_cpp DESTINATION share/doc/libfire3dv-client-dev/examples COMPONENT ${dev}
        EXCLUDE_FROM_ALL)
include(CMakePackageConfigHelpers)
configure_package_config_file(adapters/generic/cmake/fire3dv-config.cmake.in ${PROJECT_BINARY_DIR}/package/fire3dv-config.cmake
  INSTALL_DESTINATION ${libdir}/cmake/fire3dv)
install(FILES ${PROJECT_BINARY_DIR}/package/fire3dv-config.cmake
        ${PROJECT_BINARY_DIR}/adapters/generic/fire3dv-config-version.cmake
        DESTINATION ${libdir}/cmake/fire3dv COMPONENT ${dev} EXCLUDE_FROM_ALL)
function(fire3dv_package_pc)  # in a scope of its own, for the names of the template
  set(CMAKE_INSTALL_LIBDIR ${libdir})
  set(CMAKE_INSTALL_INCLUDEDIR include)
  file(RELATIVE_PATH prefix_from_pc /prefix/${libdir}/pkgconfig /prefix)
  configure_file(adapters/generic/cmake/fire3dv-client.pc.in ${PROJECT_BINARY_DIR}/package/fire3dv-client.pc @ONLY)
endfunction()
fire3dv_package_pc()
install(FILES ${PROJECT_BINARY_DIR}/package/fire3dv-client.pc DESTINATION ${libdir}/pkgconfig COMPONENT ${dev} EXCLUDE_FROM_ALL)
# The static library is one file of several: finish.cmake joins them by this script of ar.
set(static_libraries fire3dv_client_inside fire3dv_robot fire3dv_wire fire3dv_transport fire3dv_base)
set(script "create libfire3dv-client.a\n")
foreach(library ${static_libraries})
  string(APPEND script "addlib $<TARGET_FILE:${library}>\n")
endforeach()
file(GENERATE OUTPUT ${CPACK_FIRE3DV_STATIC_LIBRARY} CONTENT "${script}save\nend\n")

# Python package: modules alone, the library is that of the package above.
fire3dv_package(python3-fire3dv SECTION python ARCHITECTURE all DEPENDS "python3:any (>= 3.9), python3-numpy, ${own_library} (= ${package_version})"
  RECOMMENDS fire3dv CONTROL_EXTRA ${package_dir}/python/postinst ${package_dir}/python/prerm
  DESCRIPTION "Python package of the renderer FIRE-3DV
Publishes the poses of a simulation, and edits of its scene, to FIRE-3DV
renderers, starts renderers, and receives their images as NumPy arrays.")
set(python_component package_python3-fire3dv)
install(DIRECTORY adapters/generic/python/fire3dv DESTINATION lib/python3/dist-packages COMPONENT ${python_component} EXCLUDE_FROM_ALL
        FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
configure_file(${package_dir}/python/METADATA.in ${PROJECT_BINARY_DIR}/package/METADATA @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/package/METADATA DESTINATION lib/python3/dist-packages/fire3dv-${PROJECT_VERSION}.dist-info
        COMPONENT ${python_component} EXCLUDE_FROM_ALL)
install(FILES adapters/generic/python/README.md DESTINATION share/doc/python3-fire3dv COMPONENT ${python_component} EXCLUDE_FROM_ALL)

include(CPack)

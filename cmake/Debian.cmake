# Manual page and completions, made of the command's own --help, and the Debian package: 'cpack -G DEB' in the build
# folder, after a build.
find_package(Python3 QUIET COMPONENTS Interpreter)
find_program(MAPLESS_GZIP gzip)
if(MAPLESS_SANITIZE)
  return()
endif()
if(NOT Python3_Interpreter_FOUND OR NOT MAPLESS_GZIP)
  message(STATUS "left out, for want of Python 3 or gzip: the manual page, the completions and the Debian package")
  return()
endif()
set(manual ${PROJECT_BINARY_DIR}/manual)
configure_file(packaging/changelog.in ${manual}/changelog @ONLY)
add_custom_command(
  OUTPUT ${manual}/mapless.1.gz ${manual}/mapless.bash ${manual}/changelog.gz
  COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/scripts/make_manual.py $<TARGET_FILE:mapless_command> ${manual}
  COMMAND ${MAPLESS_GZIP} -9nf ${manual}/mapless.1
  COMMAND ${MAPLESS_GZIP} -9nc ${manual}/changelog > ${manual}/changelog.gz
  DEPENDS mapless_command scripts/make_manual.py ${manual}/changelog
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
# What it is made of and needs: the software bill of materials.
add_custom_command(
  OUTPUT ${manual}/sbom.cdx.json
  COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/scripts/make_sbom.py $<TARGET_FILE:mapless_command>
          ${PROJECT_VERSION} > ${manual}/sbom.cdx.json
  DEPENDS mapless_command scripts/make_sbom.py
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
add_custom_target(mapless_manual ALL DEPENDS ${manual}/mapless.1.gz ${manual}/sbom.cdx.json)
install(FILES ${manual}/mapless.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${manual}/mapless.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME mapless)
install(FILES ${manual}/changelog.gz ${manual}/sbom.cdx.json packaging/copyright CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/mapless)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mapless)
set(CPACK_PACKAGE_VENDOR mapless)
set(CPACK_PACKAGE_CONTACT "mapless <mapless@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "label the moving points of a spinning 3D lidar")
set(CPACK_PACKAGE_DESCRIPTION
    "Labels every point of a spinning 3D lidar as moving or still, online, scan by
scan, without a prior map, training, a ground plane or a list of classes, and
accounts for the motion of the sensor while it scans. Recordings and running
sensors (ROS 2 over DDS) are read; poses come from a file, from tf, or from
the program's own lidar odometry. Holds the command, the C++ library with its
headers, and its CMake package.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libtbb-dev, libfmt-dev")
include(CPack)

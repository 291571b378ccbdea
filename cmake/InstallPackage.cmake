# Installs the library, its headers, the command, and what find_package(mapless) needs.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/mapless)
install(TARGETS mapless EXPORT mapless-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
                                               LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS mapless_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/mapless DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT mapless-targets NAMESPACE mapless:: DESTINATION ${package_folder})

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/mapless-config.cmake.in
                              ${PROJECT_BINARY_DIR}/mapless-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mapless-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mapless-config.cmake ${PROJECT_BINARY_DIR}/mapless-config-version.cmake
        DESTINATION ${package_folder})

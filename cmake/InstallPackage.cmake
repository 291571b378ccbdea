# Installs the libraries, their headers, the command, and what find_package(mapless COMPONENTS ...) needs: an export of
# its own for each layer, so that only the packages of the wanted layers have to be there.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/mapless)
set(MAPLESS_LAYER_TABLE)
foreach(layer IN LISTS MAPLESS_LAYERS)
  install(TARGETS mapless_${layer} EXPORT mapless-${layer} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT mapless-${layer} NAMESPACE mapless:: DESTINATION ${package_folder})
  string(APPEND MAPLESS_LAYER_TABLE "set(_mapless_layers_of_${layer} ${MAPLESS_LAYERS_OF_${layer}})\n"
         "set(_mapless_packages_of_${layer} \"${MAPLESS_PACKAGES_OF_${layer}}\")\n")
endforeach()
install(TARGETS mapless EXPORT mapless-all)
install(EXPORT mapless-all NAMESPACE mapless:: DESTINATION ${package_folder})
install(TARGETS mapless_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/mapless DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/mapless-config.cmake.in
                              ${PROJECT_BINARY_DIR}/mapless-config.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mapless-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mapless-config.cmake ${PROJECT_BINARY_DIR}/mapless-config-version.cmake
        DESTINATION ${package_folder})

# mapless-built.cmake lets another CMake project link the libraries of this build folder without installing them: the
# Python binding is tested so, without compiling the library twice.
list(TRANSFORM MAPLESS_LAYERS PREPEND mapless_ OUTPUT_VARIABLE targets)
export(TARGETS ${targets} mapless mapless_options mapless_verbs NAMESPACE mapless:: FILE ${PROJECT_BINARY_DIR}/mapless-built.cmake)

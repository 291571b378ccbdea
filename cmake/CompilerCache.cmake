# ccache where there is one. The sloppiness lets it cache precompiled headers; the base folder, and paths in debug
# information that begin there, let one checkout use what another has compiled.
find_program(MAPLESS_CCACHE ccache)
if(MAPLESS_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
                                  CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${MAPLESS_CCACHE})
  add_compile_options(-fdebug-prefix-map=${PROJECT_BINARY_DIR}=.)
endif()

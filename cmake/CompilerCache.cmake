# ccache where there is one. The sloppiness lets it cache precompiled headers.
find_program(MAPLESS_CCACHE ccache)
if(MAPLESS_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
                                  ${MAPLESS_CCACHE})
endif()

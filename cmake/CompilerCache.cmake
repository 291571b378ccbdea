# ccache where there is one. It must be told that precompiled headers may be cached.
find_program(MAPLESS_CCACHE ccache)
if(MAPLESS_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros
                                  ${MAPLESS_CCACHE})
endif()

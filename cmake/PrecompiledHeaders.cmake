# For builds that are compiled once and thrown away, such as those with sanitizers. Off otherwise, because with it
# a missing #include goes unnoticed.
if(NOT MAPLESS_PRECOMPILE_HEADERS)
  return()
endif()

set(slow_headers <Eigen/Dense> <algorithm> <filesystem> <functional> <memory> <optional> <string> <vector>)
target_precompile_headers(mapless PRIVATE ${slow_headers})
if(MAPLESS_BUILD_TESTS)
  target_precompile_headers(mapless_test_support PRIVATE ${slow_headers} <gtest/gtest.h>)
  get_property(test_targets DIRECTORY ${PROJECT_SOURCE_DIR}/tests PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${test_targets})
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)
      target_precompile_headers(${target} REUSE_FROM mapless_test_support)
    endif()
  endforeach()
endif()

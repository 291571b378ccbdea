# For builds that are compiled once: release and sanitizer presets. Reading headers is half of the compiler's time.
# Off in the dev preset, because with it a missing #include goes unnoticed.
if(NOT MAPLESS_PRECOMPILE_HEADERS)
  return()
endif()

# GCC 12 forgets there which code is the standard library's, and warns of it.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(mapless_options INTERFACE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread
                                                   -Wno-restrict)
endif()

set(slow_headers <Eigen/Dense> <algorithm> <filesystem> <functional> <memory> <optional> <string> <vector>
                 <fmt/format.h> <oneapi/tbb/parallel_for.h>)
target_precompile_headers(mapless_core PRIVATE ${slow_headers})
foreach(layer IN LISTS MAPLESS_LAYERS)
  if(NOT layer STREQUAL core)
    target_precompile_headers(mapless_${layer} REUSE_FROM mapless_core)
  endif()
endforeach()
target_precompile_headers(mapless_verbs PRIVATE ${slow_headers} <CLI/CLI.hpp> <nlohmann/json.hpp>)
if(MAPLESS_BUILD_TESTS)
  target_precompile_headers(mapless_test_support PRIVATE ${slow_headers} <gtest/gtest.h> <gmock/gmock.h>)
  get_property(test_targets DIRECTORY ${PROJECT_SOURCE_DIR}/tests PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${test_targets})
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)
      target_precompile_headers(${target} REUSE_FROM mapless_test_support)
    endif()
  endforeach()
endif()

# The checks beside the unit tests, as tests of the same ctest run, so that one summary has all of them.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
find_program(MAPLESS_CLANG_FORMAT NAMES clang-format-14 clang-format REQUIRED)
find_program(MAPLESS_RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy REQUIRED)
find_program(MAPLESS_DOXYGEN doxygen REQUIRED)
set(scripts ${PROJECT_SOURCE_DIR}/scripts)

function(mapless_check name)
  add_test(NAME ${name} COMMAND ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(${name} PROPERTIES TIMEOUT 3600)
endfunction()

# Such a check has the machine to itself, and uses as many processes as the environment's JOBS says, or as it has cores.
function(mapless_parallel_check name)
  mapless_check(${name} ${ARGN})
  set_tests_properties(${name} PROPERTIES RUN_SERIAL ON)
endfunction()

# Each version of clang-format has a taste of its own.
execute_process(COMMAND ${MAPLESS_CLANG_FORMAT} --version OUTPUT_VARIABLE clang_format_version)
if(clang_format_version MATCHES "version 14[.]")
  mapless_check(lint.format ${scripts}/check_format.sh ${MAPLESS_CLANG_FORMAT})
else()
  message(STATUS "left out, because ${MAPLESS_CLANG_FORMAT} is not version 14: lint.format")
endif()
mapless_check(lint.layers ${Python3_EXECUTABLE} ${scripts}/check_layers.py)
mapless_check(lint.includes ${Python3_EXECUTABLE} ${scripts}/check_includes.py)
mapless_check(lint.documents ${Python3_EXECUTABLE} ${scripts}/check_documents.py)
mapless_check(lint.filters ${Python3_EXECUTABLE} ${scripts}/check_test_filters.py)
mapless_check(lint.mutants ${Python3_EXECUTABLE} ${scripts}/try_mutants.py --check)
mapless_check(lint.checks ${Python3_EXECUTABLE} -m unittest discover -s tests/scripts -p "*_test.py")
mapless_parallel_check(lint.tidy ${scripts}/check_tidy.sh ${MAPLESS_RUN_CLANG_TIDY} ${PROJECT_SOURCE_DIR}/build/tidy)

mapless_parallel_check(lint.headers ${Python3_EXECUTABLE} ${scripts}/check_headers.py --compiler ${CMAKE_CXX_COMPILER}
                       --generated ${PROJECT_BINARY_DIR}/src ${PROJECT_BINARY_DIR}/apps/mapless)
mapless_check(docs.reference ${MAPLESS_DOXYGEN} docs/Doxyfile)

# Recordings are simulated: without the simulator there is nothing to compare.
if(MAPLESS_SIMULATOR)
  mapless_parallel_check(regression.digests ${Python3_EXECUTABLE} ${scripts}/check_digests.py $<TARGET_FILE:mapless_command>)
endif()

mapless_check(package.hardening ${scripts}/check_hardening.sh $<TARGET_FILE:mapless_command>)
mapless_check(package.example ${scripts}/check_package.sh ${PROJECT_BINARY_DIR}
              $<$<TARGET_EXISTS:mapless_make_scene>:$<TARGET_FILE:mapless_make_scene>>)

# Skipped, by name, where npm, its registry or Chromium is missing.
mapless_check(viewer.page ${scripts}/check_viewer.sh $<TARGET_FILE:mapless_command> ${PROJECT_BINARY_DIR})
set_tests_properties(viewer.page PROPERTIES SKIP_RETURN_CODE 77)

# Skipped, by name, where PyPI cannot be reached.
mapless_check(package.wheel ${scripts}/check_wheel.sh ${PROJECT_BINARY_DIR})
set_tests_properties(package.wheel PROPERTIES SKIP_RETURN_CODE 77)

mapless_check(ros2.package ${scripts}/check_ros2.sh $<TARGET_FILE:mapless_command> ${CMAKE_CXX_COMPILER})

# As above; and where this build has no DDS.
mapless_parallel_check(live.dds ${scripts}/check_live.sh $<TARGET_FILE:mapless_command>)
set_tests_properties(live.dds PROPERTIES SKIP_RETURN_CODE 77)

mapless_parallel_check(sanitizer.address_undefined ${scripts}/check_sanitizer.sh asan)
mapless_parallel_check(sanitizer.thread ${scripts}/check_sanitizer.sh tsan)

# Flags of our own targets only: a project that links mapless chooses its own. Nothing here is specific to the
# machine that builds, so that one build runs on any machine of its architecture and gives the same bytes.
add_library(mapless_options INTERFACE)
target_compile_options(mapless_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                                                 -Woverloaded-virtual -Wconversion -Wno-sign-conversion)
if(MAPLESS_WARNINGS_AS_ERRORS)
  target_compile_options(mapless_options INTERFACE -Werror)
endif()

# Against malicious input (docs/reliability.md): all symbols are bound at the start, in memory that is read-only then.
# What it needs of the compiler is left to released binaries.
if(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND NOT MAPLESS_SANITIZE)
  target_link_options(mapless_options INTERFACE LINKER:-z,relro,-z,now)
endif()
if(MAPLESS_HARDEN)
  target_compile_options(mapless_options INTERFACE -fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2)
endif()

if(CMAKE_UNITY_BUILD)
  # Wrong there: a source of ours counts as a header, because another file includes it.
  target_compile_options(mapless_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  # GCC collects its garbage later, at 512 MB in place of 128 MB: 8 % of the time of a test file, measured.
  target_compile_options(mapless_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=524288>)
endif()

if(MAPLESS_SANITIZE)
  # maybe-uninitialized is wrong about instrumented Eigen code too often to be of use.
  target_compile_options(mapless_options INTERFACE -fsanitize=${MAPLESS_SANITIZE} -fno-omit-frame-pointer
                                                   -fno-sanitize-recover=all
                                                   $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(mapless_options INTERFACE -fsanitize=${MAPLESS_SANITIZE})
endif()
if(MAPLESS_SANITIZE MATCHES "undefined")
  # A check of every pointer doubles the time it takes to compile Eigen code. AddressSanitizer stops at null and
  # out-of-bounds ones too.
  target_compile_options(mapless_options INTERFACE -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow)
endif()
if(MAPLESS_SANITIZE STREQUAL "thread")
  target_include_directories(mapless_options BEFORE INTERFACE ${PROJECT_SOURCE_DIR}/tests/thread_sanitizer)
endif()

# Sets MAPLESS_SIMULATOR where the simulator is wanted and an Embree is there; embree_VERSION_MAJOR says which.
set(MAPLESS_SIMULATOR OFF)
if(MAPLESS_BUILD_SIMULATOR)
  find_package(embree 4 QUIET)
  if(NOT embree_FOUND)
    find_package(embree 3 QUIET)
  endif()
  set(MAPLESS_SIMULATOR ${embree_FOUND})
  if(NOT embree_FOUND)
    message(STATUS "Embree (Debian: libembree-dev) was not found: this build has no simulator, and its command no "
                   "verbs simulate and benchmark")
  endif()
endif()

# Sets MAPLESS_DDS where `mapless live` is wanted and Cyclone DDS with its compiler of messages is there.
set(MAPLESS_DDS OFF)
if(MAPLESS_BUILD_LIVE)
  find_package(CycloneDDS 0.10 QUIET)
  find_program(MAPLESS_IDLC idlc)
  if(CycloneDDS_FOUND AND MAPLESS_IDLC)
    set(MAPLESS_DDS ON)
    enable_language(C) # of the compiled messages
  else()
    message(STATUS "Cyclone DDS 0.10 (Debian: cyclonedds-dev, cyclonedds-tools) was not found: the command of this "
                   "build has no verb live")
  endif()
endif()

# In a unity build, the sources of one folder (a room) are compiled as one: fewer units, in which headers are read and
# templates instantiated once, and two rooms may give one name to two things.
function(unity_by_folder target)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(source MATCHES "/([^/]+)/[^/]+[.]cpp$")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${CMAKE_MATCH_1})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

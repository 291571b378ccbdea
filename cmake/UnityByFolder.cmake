# In a unity build, the sources of one folder (a room) are compiled as one: fewer units, in which headers are read and
# templates instantiated once, and two rooms may give one name to two things. Small folders are compiled together:
# reading the headers takes them longest, and in none of them is a name given twice.
set(small_folders
    random scenes simulation traffic # src/simulation
    explain export options pictures reports rig run terminal trust view) # apps/mapless

function(unity_by_folder target)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(source MATCHES "/([^/]+)/[^/]+[.]cpp$")
      set(group ${CMAKE_MATCH_1})
      if(group IN_LIST small_folders)
        set(group small)
      endif()
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

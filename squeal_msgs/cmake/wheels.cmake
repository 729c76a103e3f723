# Makes ROS that pip installed found, which has nothing to source; changes nothing for another one.

set(Python3_FIND_STRATEGY LOCATION)  # that of the active environment, not the newest one
find_package(Python3 REQUIRED COMPONENTS Interpreter)
execute_process(
  COMMAND "${Python3_EXECUTABLE}" -c "import pathlib, ament_package; print(next(p for p in
    pathlib.Path(ament_package.__file__).parents if (p / 'share' / 'ament_index').is_dir()))"
  OUTPUT_VARIABLE prefix OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(prefix)
  file(TO_CMAKE_PATH "$ENV{AMENT_PREFIX_PATH}" known)
  if(NOT prefix IN_LIST known)
    list(APPEND CMAKE_PREFIX_PATH "${prefix}")
    if(known)
      set(ENV{AMENT_PREFIX_PATH} "$ENV{AMENT_PREFIX_PATH}:${prefix}")
    else()
      set(ENV{AMENT_PREFIX_PATH} "${prefix}")
    endif()
  endif()
endif()

# The imported targets of the wheels name include folders of the machine that built the wheels.
function(drop_missing_include_folders)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(folders)
      set(kept)
      foreach(folder IN LISTS folders)
        if(NOT IS_ABSOLUTE "${folder}" OR EXISTS "${folder}")  # generator expressions stay
          list(APPEND kept "${folder}")
        endif()
      endforeach()
      set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept}")
    endif()
  endforeach()
endfunction()
cmake_language(DEFER CALL drop_missing_include_folders)

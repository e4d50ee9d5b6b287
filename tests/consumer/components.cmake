# `cmake -D PREFIX=… -D WORK=… -P components.cmake`
# A misspelt component of the installed package is an error with the nearest name, and a warning if it is optional. A project
# without a build type is warned once.
function(configure package components ok message)
  file(REMOVE_RECURSE ${WORK})
  file(WRITE ${WORK}/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)\nproject(misspelt LANGUAGES CXX)\n"
    "find_package(${package} CONFIG REQUIRED ${components})\nfind_package(${package} CONFIG REQUIRED ${components})\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK} -B ${WORK}/build -D CMAKE_PREFIX_PATH=${PREFIX}
    RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")  # CMake breaks lines
  if(NOT text MATCHES "${message}" OR (ok AND NOT code EQUAL 0) OR (NOT ok AND code EQUAL 0))
    message(FATAL_ERROR "${package} ${components}: exit code ${code}, expected '${message}'\n${text}")
  endif()
  set(printed "${text}" PARENT_SCOPE)
endfunction()

foreach(package tenon Tenon)
  configure(${package} "COMPONENTS sytems" NO
    "no component 'sytems' here. did you mean 'systems'. Installed components: [a-z_, ]*systems")
  configure(${package} "OPTIONAL_COMPONENTS sytems" YES "no component 'sytems' here. did you mean 'systems'")
  configure(${package} "COMPONENTS systems" YES "CMAKE_BUILD_TYPE is empty[^@]*")
  if(NOT WITH_DDS)
    configure(${package} "COMPONENTS unitree" NO "no component 'unitree' here: it needs Cyclone DDS, so install cyclonedds-dev")
  endif()
  string(REGEX MATCHALL "CMAKE_BUILD_TYPE is empty" warnings "${printed}")
  list(LENGTH warnings count)
  if(NOT count EQUAL 1)
    message(FATAL_ERROR "${count} warnings of an empty build type")
  endif()
endforeach()

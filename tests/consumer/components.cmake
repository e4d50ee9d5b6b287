# `cmake -D PREFIX=… -D WORK=… -P components.cmake`
# A misspelt component of the installed package is an error with its name, and a warning if it is optional.
function(configure components ok message)
  file(REMOVE_RECURSE ${WORK})
  file(WRITE ${WORK}/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)\nproject(misspelt LANGUAGES CXX)\n"
    "find_package(tenon CONFIG REQUIRED ${components})\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK} -B ${WORK}/build -D CMAKE_PREFIX_PATH=${PREFIX}
    RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  string(REGEX REPLACE "[ \n]+" " " text "${text}")  # CMake breaks lines
  if(NOT text MATCHES "${message}" OR (ok AND NOT code EQUAL 0) OR (NOT ok AND code EQUAL 0))
    message(FATAL_ERROR "${components}: exit code ${code}, expected '${message}'\n${text}")
  endif()
endfunction()

configure("COMPONENTS sytems" NO "no component 'sytems' here. Installed components: [a-z_, ]*systems")
configure("OPTIONAL_COMPONENTS sytems" YES "no component 'sytems' here.")

# `cmake -D PREFIX=… -D SOURCE=… -D WORK=… -D FLAGS=… -P run.cmake`
# Builds the consumer against an installation, with and without NDEBUG, and runs its programs.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT code EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${command}\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
foreach(config Release Debug)
  set(build ${WORK}/${config})
  run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer -B ${build} -G Ninja -D CMAKE_BUILD_TYPE=${config}
    -D CMAKE_PREFIX_PATH=${PREFIX} -D EXAMPLES=${PREFIX}/share/tenon/examples
    -D "CMAKE_CXX_FLAGS=-Wall -Wextra -Werror ${FLAGS}")
  run(${CMAKE_COMMAND} --build ${build})
  file(GLOB programs ${build}/bin/*)
  list(LENGTH programs count)
  if(count LESS 25)
    message(FATAL_ERROR "only these programs were built: ${programs}")
  endif()
  foreach(program IN LISTS programs)
    run(${program} WORKING_DIRECTORY ${build})
  endforeach()
  run(${build}/apps/cart-app ${PREFIX}/share/tenon/examples/app/step.yaml --out ${build}/step)
endforeach()

# `cmake -D PREFIX=… -D SOURCE=… -D WORK=… -D COMPILER=… -P border.cmake`
# A program with other compiler options than the installed library works, or does not link and the linker names the option.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
file(GLOB_RECURSE directories ${PREFIX}/tenon-systems.pc)
cmake_path(GET directories PARENT_PATH directory)
cmake_path(GET directory PARENT_PATH libraries)
set(ENV{PKG_CONFIG_PATH} ${directory})
execute_process(COMMAND pkg-config --cflags --libs tenon-systems OUTPUT_VARIABLE package
  OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(package UNIX_COMMAND "${package}")
function(build code text)
  execute_process(COMMAND ${COMPILER} -std=c++20 -O1 ${ARGN}
    ${SOURCE}/tests/consumer/border.cc -o ${WORK}/border ${package} -Wl,-rpath,${libraries}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(${code} ${result} PARENT_SCOPE)
  set(${text} "${output}" PARENT_SCOPE)
endfunction()

file(READ /proc/cpuinfo processor)
# All public headers together have no warnings, also where they are no system headers.
file(GLOB_RECURSE headers RELATIVE ${PREFIX}/include ${PREFIX}/include/*.h)
list(FILTER headers EXCLUDE REGEX "/internal/")
list(TRANSFORM headers REPLACE ".+" "#include <\\0>\n")
file(WRITE ${WORK}/headers.cc ${headers})
set(others ${package})
list(FILTER others INCLUDE REGEX "^-I")
list(TRANSFORM others REPLACE "^-I" "-isystem")
execute_process(COMMAND ${COMPILER} -std=c++20 -fsyntax-only -Wall -Wextra -Wshadow -Wconversion -Werror ${WORK}/headers.cc
  ${SOURCE}/tests/consumer/border.cc -I${PREFIX}/include ${others} -isystem${SIMBODY}/ COMMAND_ERROR_IS_FATAL ANY)

# With -mavx512f, headers of GCC 12 have some.
set(options "-march=native" "-fsanitize=address" "-march=native -fsanitize=address" "-std=c++2b" "-DNDEBUG"
  "-DEIGEN_MAX_ALIGN_BYTES=32" "-DEIGEN_INITIALIZE_MATRICES_BY_NAN")
foreach(vectors avx2 avx512f)
  if(processor MATCHES "${vectors}")
    list(APPEND options "-m${vectors} -mfma")
  endif()
endforeach()
foreach(option IN LISTS options)
  separate_arguments(arguments UNIX_COMMAND "${option}")
  build(code text ${arguments})
  if(code EQUAL 0)
    execute_process(COMMAND ${WORK}/border RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
  endif()
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${option}: ${code}\n${text}")
  endif()
endforeach()

function(fails option message)
  build(code text ${option})
  if(code EQUAL 0 OR NOT text MATCHES "${message}")
    message(FATAL_ERROR "${option}: ${code}, expected ${message}\n${text}")
  endif()
endfunction()
set(linker "tenon::the_library_does_not_fit_this_program_in_which::")
fails(-D_GLIBCXX_DEBUG "${linker}GLIBCXX_DEBUG_is<1>")
fails(-DEIGEN_MAX_STATIC_ALIGN_BYTES=0 "${linker}EIGEN_MAX_STATIC_ALIGN_BYTES_is<0>")
fails(-DEIGEN_DEFAULT_DENSE_INDEX_TYPE=int "${linker}the_size_of_Eigen_Index_is<4>")
fails(-DEIGEN_DEFAULT_TO_ROW_MAJOR "matrices in signals must be column-major")

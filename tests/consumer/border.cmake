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
# The headers have no warnings. With -mavx512f, headers of GCC 12 have some.
set(options "-Wall -Wextra -Wshadow -Wconversion -Werror" "-march=native" "-fsanitize=address" "-march=native -fsanitize=address" "-std=c++23" "-DNDEBUG"
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

function(does_not_link option name)
  build(code text ${option})
  if(code EQUAL 0 OR NOT text MATCHES "tenon::the_library_does_not_fit_this_program_in_which::${name}")
    message(FATAL_ERROR "${option}: ${code}, expected ${name}\n${text}")
  endif()
endfunction()
does_not_link(-D_GLIBCXX_DEBUG "GLIBCXX_DEBUG_is<1>")
does_not_link(-DEIGEN_MAX_STATIC_ALIGN_BYTES=0 "EIGEN_MAX_STATIC_ALIGN_BYTES_is<0>")
does_not_link(-DEIGEN_DEFAULT_DENSE_INDEX_TYPE=int "the_size_of_Eigen_Index_is<4>")
does_not_link(-DEIGEN_DEFAULT_TO_ROW_MAJOR "EIGEN_DEFAULT_TO_ROW_MAJOR_is<1>")

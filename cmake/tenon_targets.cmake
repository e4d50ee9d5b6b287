# tenon_add_library(NAME SOURCES... ) makes the shared library tenon_NAME, known as tenon::NAME, with the
# warnings, the include directory and the install rules that all of Tenon's libraries share.
function(tenon_add_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(tenon_${name} SHARED ${arg_SOURCES})
  add_library(tenon::${name} ALIAS tenon_${name})
  target_compile_features(tenon_${name} PUBLIC cxx_std_20)
  target_include_directories(tenon_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(tenon_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  set_target_properties(tenon_${name} PROPERTIES EXPORT_NAME ${name})
  tenon_warnings(tenon_${name})
  install(TARGETS tenon_${name} EXPORT tenon-targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

# -Wno-restrict: GCC 12 warns of overlapping copies inside operator+ of strings, falsely (GCC bug 105651).
function(tenon_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> $<$<BOOL:${TENON_WERROR}>:-Werror>)
endfunction()

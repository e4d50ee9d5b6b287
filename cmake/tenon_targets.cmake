# tenon_headers(TARGET SOURCE_DIRECTORY [PUBLIC HEADERS…] [INTERNAL HEADERS…] [PRIVATE HEADERS…]): makes the headers of the
# target available as <tenon/SOURCE_DIRECTORY/HEADER>. In the build tree, a file of that name includes the file of the source
# tree, so compiler messages, debuggers and coverage reports name the file to edit. Public headers are installed and compile
# alone, which the target all_verify_interface_header_sets checks. Internal headers are installed because public headers
# include them. Private headers are not installed.
function(tenon_headers target source_directory)
  cmake_parse_arguments(arg "" "" "PUBLIC;INTERNAL;PRIVATE" ${ARGN})
  set(root ${PROJECT_BINARY_DIR}/include/${target})
  set(public)
  foreach(header IN LISTS arg_PUBLIC arg_INTERNAL arg_PRIVATE)
    set(link ${root}/tenon/${source_directory}/${header})
    file(CONFIGURE OUTPUT ${link} CONTENT "#include \"${PROJECT_SOURCE_DIR}/${source_directory}/${header}\"\n" @ONLY)
    if(header IN_LIST arg_PUBLIC)
      list(APPEND public ${link})
    endif()
  endforeach()
  get_target_property(type ${target} TYPE)
  if(type STREQUAL INTERFACE_LIBRARY)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${root}>)
  else()
    target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${root}>)
  endif()
  if(public)
    if(NOT TARGET ${target}_headers)
      add_library(${target}_headers INTERFACE)
      target_link_libraries(${target}_headers INTERFACE ${target})
      set_target_properties(${target}_headers PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
    endif()
    target_sources(${target}_headers INTERFACE FILE_SET HEADERS BASE_DIRS ${root} FILES ${public})
  endif()
  if(TENON_INSTALL)
    foreach(header IN LISTS arg_PUBLIC arg_INTERNAL)
      cmake_path(GET header PARENT_PATH directory)
      install(FILES ${PROJECT_SOURCE_DIR}/${source_directory}/${header}
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tenon/${source_directory}/${directory} COMPONENT tenon_development)
    endforeach()
  endif()
endfunction()

# tenon_add_library(NAME COMPONENT SOURCES… LINK_PUBLIC… LINK_PRIVATE…): creates the library tenon_NAME with the alias
# tenon::NAME, and the warnings and install rules of all Tenon libraries. A shared library exports only symbols of Tenon.
function(tenon_add_library name component)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK_PUBLIC;LINK_PRIVATE" ${ARGN})
  set(target tenon_${name})
  add_library(${target} ${arg_SOURCES})
  add_library(tenon::${name} ALIAS ${target})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${arg_LINK_PUBLIC} PRIVATE ${arg_LINK_PRIVATE})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  tenon_as_library(${target})
  tenon_precompile(${target})
  tenon_set_rpath(${target})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL SHARED_LIBRARY)
    set(map ${PROJECT_SOURCE_DIR}/cmake/tenon.map)
    target_link_options(${target} PRIVATE LINKER:--version-script=${map})
    # See the file that is added.
    set(adopt ${PROJECT_SOURCE_DIR}/systems/framework/types/internal/adopt_eigen_memory.cc)
    target_sources(${target} PRIVATE ${adopt})
    set_source_files_properties(${adopt} PROPERTIES SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
    target_link_options(${target} PRIVATE LINKER:--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free)
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${map})
  endif()
  tenon_warnings(${target})
  if(NOT PROJECT_IS_TOP_LEVEL)
    set_target_properties(${target} PROPERTIES SYSTEM ON)  # no warnings of headers, as from an installed library
  endif()
  if(TENON_INSTALL)
    if(type STREQUAL SHARED_LIBRARY)
      tenon_pkg_config(${name} ${arg_LINK_PUBLIC})
    endif()
    install(TARGETS ${target} EXPORT tenon-${component}-targets
      LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT tenon_runtime NAMELINK_COMPONENT tenon_development
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT tenon_development)
    set_property(GLOBAL APPEND PROPERTY TENON_EXPORTS ${component})
  endif()
endfunction()

# tenon_pkg_config(NAME LIBRARIES…): installs tenon-NAME.pc. LIBRARIES are those of its LINK_PUBLIC.
function(tenon_pkg_config name)
  set(needs ${ARGN})
  list(TRANSFORM needs REPLACE "^tenon::" "tenon-")
  list(TRANSFORM needs REPLACE "^Eigen3::Eigen$" "eigen3")
  list(JOIN needs " " needs)
  set(directory ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH to_prefix ${directory} ${CMAKE_INSTALL_PREFIX})
  # Not -I: warnings of the user's compiler do not apply to the headers.
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/pkgconfig/tenon-${name}.pc CONTENT "prefix=\${pcfiledir}/${to_prefix}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}
includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}

Name: tenon-${name}
Description: ${PROJECT_DESCRIPTION}: ${name}
URL: ${PROJECT_HOMEPAGE_URL}
Version: ${PROJECT_VERSION}
Requires: ${needs}
Cflags: -isystem \${includedir}
Libs: -L\${libdir} -ltenon_${name}
" @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/pkgconfig/tenon-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT tenon_development)
endfunction()

# tenon_precompile(TARGET): the target uses the common precompiled headers, Eigen and tenon/systems/block.h.
# CMAKE_DISABLE_PRECOMPILE_HEADERS disables them.
function(tenon_precompile target)
  if(NOT TARGET tenon_precompiled)
    add_library(tenon_precompiled OBJECT ${PROJECT_SOURCE_DIR}/systems/precompiled.cc)
    target_compile_features(tenon_precompiled PRIVATE cxx_std_20)
    target_link_libraries(tenon_precompiled PRIVATE Eigen3::Eigen)
    target_include_directories(tenon_precompiled PRIVATE
      $<TARGET_PROPERTY:tenon_systems,INTERFACE_INCLUDE_DIRECTORIES>)
    target_precompile_headers(tenon_precompiled PRIVATE
      <Eigen/Cholesky> <Eigen/Geometry> <Eigen/LU> <tenon/systems/block.h>)
    tenon_as_library(tenon_precompiled)
    tenon_warnings(tenon_precompiled)
  endif()
  target_precompile_headers(${target} REUSE_FROM tenon_precompiled)
endfunction()

# tenon_runs_once(TARGET): the code of the target runs once per run, so -O1 saves a sixth of its compile time.
function(tenon_runs_once target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# tenon_as_library(TARGET): compile options of all library code, including static libraries.
function(tenon_as_library target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# tenon_warnings(TARGET): enables compiler warnings. GCC 12 reports overlapping copies in operator+ of strings by mistake (GCC bug
# 105651), hence -Wno-restrict.
function(tenon_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    $<$<BOOL:${TENON_WERROR}>:-Werror>)
endfunction()

# tenon_set_rpath(TARGET): installed libraries and programs find each other at any prefix.
function(tenon_set_rpath target)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN;$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endfunction()

# tenon_dds_types(TARGET IDL): the object library TARGET with the types that idlc makes of the file IDL.idl.
function(tenon_dds_types target idl)
  set(types ${CMAKE_CURRENT_BINARY_DIR}/${target})
  cmake_path(GET idl FILENAME name)
  file(MAKE_DIRECTORY ${types})
  add_custom_command(OUTPUT ${types}/${name}.c ${types}/${name}.h
    COMMAND ${TENON_IDLC} ${CMAKE_CURRENT_SOURCE_DIR}/${idl}.idl WORKING_DIRECTORY ${types} DEPENDS ${idl}.idl VERBATIM)
  add_library(${target} OBJECT ${types}/${name}.c ${types}/${name}.h)
  target_include_directories(${target} SYSTEM PUBLIC ${types} ${TENON_DDS_INCLUDE})
  target_compile_options(${target} PRIVATE -w)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
endfunction()

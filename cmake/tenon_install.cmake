include(CMakePackageConfigHelpers)

set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tenon)
install(EXPORT tenon-targets NAMESPACE tenon:: DESTINATION ${cmake_dir})
configure_package_config_file(cmake/tenon-config.cmake.in ${PROJECT_BINARY_DIR}/tenon-config.cmake
  INSTALL_DESTINATION ${cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tenon-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tenon-config.cmake ${PROJECT_BINARY_DIR}/tenon-config-version.cmake
  DESTINATION ${cmake_dir})

install(DIRECTORY systems plants controllers diagrams DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tenon
  FILES_MATCHING PATTERN "*.h"
  PATTERN simbody.h EXCLUDE PATTERN sundials_solver.h EXCLUDE)  # they include what no public header may
install(DIRECTORY tests/testing DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tenon/tests FILES_MATCHING PATTERN "*.h")
install(DIRECTORY plants/robots controllers/gaits controllers/profiles apps/scenarios docs/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/tenon)

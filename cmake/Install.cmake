# `cmake --install` and find_package(lamella): the program, the static libraries and their headers.
#
#   find_package(lamella REQUIRED)
#   target_link_libraries(mine PRIVATE lamella::pipeline)     # or lamella::depth, lamella::lightfield ...

include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(LAMELLA_FOLDERS lightfield depth distribute calibration datasets_synthetic pipeline)
list(TRANSFORM LAMELLA_FOLDERS PREPEND lamella_ OUTPUT_VARIABLE libraries)
install(TARGETS ${libraries} EXPORT lamellaTargets)
install(TARGETS lamella)

foreach(folder ${LAMELLA_FOLDERS})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lamella
    FILES_MATCHING PATTERN "*.h" PATTERN program EXCLUDE)
endforeach()

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/lamella)
install(EXPORT lamellaTargets NAMESPACE lamella:: DESTINATION ${config_folder})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/lamellaConfig.cmake.in
  ${PROJECT_BINARY_DIR}/lamellaConfig.cmake INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/lamellaConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lamellaConfig.cmake
  ${PROJECT_BINARY_DIR}/lamellaConfigVersion.cmake DESTINATION ${config_folder})

# What `cmake --install` puts where. The libraries and their headers are installed by uiclink_add_library.

include(CMakePackageConfigHelpers)

set(UICLINK_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/uiclink)
set(UICLINK_INSTALL_DATADIR ${CMAKE_INSTALL_DATADIR}/uiclink)

# The package: find_package(uiclink) gives uiclink::model, uiclink::data, ...
install(EXPORT uiclinkTargets NAMESPACE uiclink:: DESTINATION ${UICLINK_INSTALL_CMAKEDIR})
configure_package_config_file(
  cmake/uiclinkConfig.cmake.in ${PROJECT_BINARY_DIR}/cmake/uiclinkConfig.cmake
  INSTALL_DESTINATION ${UICLINK_INSTALL_CMAKEDIR}
  PATH_VARS UICLINK_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/uiclinkConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)  # before 1.0 a minor version may change the interface
install(FILES
  ${PROJECT_BINARY_DIR}/cmake/uiclinkConfig.cmake
  ${PROJECT_BINARY_DIR}/cmake/uiclinkConfigVersion.cmake
  DESTINATION ${UICLINK_INSTALL_CMAKEDIR})

# The programs. The rig stays at home: it makes this project's records and is no tool for users.
foreach(target IN ITEMS uiclink_identify_program uiclink_wagon_program)
  if(TARGET ${target})
    install(TARGETS ${target} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endforeach()
if(TARGET uiclink_identify_program)
  # ImageMagick, too, has a program `identify`: ours answers to a second name. A link, relative, so that the tree may move.
  install(CODE "
    set(bin \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
    file(CREATE_LINK identify \"\${bin}/uiclink-identify\" SYMBOLIC)
    message(STATUS \"Installing: \${bin}/uiclink-identify\")")
endif()

# What a user may want to replace; beside it, in the source tree, stands the reader of these files.
install(DIRECTORY data/ DESTINATION ${UICLINK_INSTALL_DATADIR}
  FILES_MATCHING
  PATTERN "*.toml"
  PATTERN "*.md"
  PATTERN "*.txt"
  PATTERN CMakeLists.txt EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Installs the libraries with their headers, the package for find_package(pliant), and pliant.pc and
# pliant-bullet.pc for pkg-config.
include(CMakePackageConfigHelpers)

set(PLIANT_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/pliant)

# Who links the static library needs what it calls.
if(PLIANT_WITH_CCD AND NOT BUILD_SHARED_LIBS)
    set(PLIANT_NEEDS_CCD ON)
    set(PLIANT_PC_REQUIRES ccd)
endif()

# Installs TARGET with its headers as pliant::EXPORT_NAME, and PC_NAME.pc.
function(pliant_install target export_name pc_name)
    install(TARGETS ${target} EXPORT ${target}-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime
        FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${export_name})
    install(EXPORT ${target}-targets NAMESPACE pliant:: DESTINATION ${PLIANT_CMAKE_DIR} COMPONENT development)
    # Relative to where the file lies, so that an installed tree can be moved.
    file(RELATIVE_PATH PLIANT_PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
    string(REGEX REPLACE "/$" "" PLIANT_PC_PREFIX ${PLIANT_PC_PREFIX})
    configure_file(cmake/${pc_name}.pc.in ${pc_name}.pc @ONLY)
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${pc_name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT development)
endfunction()

pliant_install(pliant pliant pliant)
if(TARGET pliant_bullet)
    pliant_install(pliant_bullet bullet pliant-bullet)
endif()

configure_package_config_file(cmake/pliant-config.cmake.in pliant-config.cmake INSTALL_DESTINATION ${PLIANT_CMAKE_DIR})
write_basic_package_version_file(pliant-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pliant-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/pliant-config-version.cmake
    DESTINATION ${PLIANT_CMAKE_DIR} COMPONENT development)

if(PLIANT_DEBIAN_PACKAGES)
    include(packaging/debian/packages.cmake)
endif()

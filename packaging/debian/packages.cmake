# Debian packages by CPack: libpliant0, libpliant-dev, pliant-tools and python3-pliant. build.sh sets PLIANT_DEBIAN_PACKAGES and what goes
# with it.
set(PLIANT_PACKAGE_CONTACT "Pliant maintainers <maintainers@pliant.example>" CACHE STRING "Maintainer that packages name")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "${PLIANT_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "soft-body dynamics for games and laboratories")
set(CPACK_PACKAGE_DESCRIPTION "Cloth, ropes, balloons and soft solids by three solvers, as a library
in C with a bridge to the Bullet physics engine.")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development tools python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/core ${CMAKE_BINARY_DIR}/bullet_bridge)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
    WORLD_EXECUTE)

set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libpliant0)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION}\nThis package has the shared libraries.")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/symbols ${CMAKE_BINARY_DIR}/shlibs
    ${CMAKE_BINARY_DIR}/triggers)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpliant-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libpliant0 (= ${version}), libbullet-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "${CPACK_PACKAGE_DESCRIPTION}\nThis package has the headers, for CMake and pkg-config.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME pliant-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "libpliant0 (= ${version})")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION
    "${CPACK_PACKAGE_DESCRIPTION}\nThis package has the program pliant, which runs and measures scenes.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-pliant)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "libpliant0 (>= ${PROJECT_VERSION}), python3:any, python3-cffi, python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/debian/python3/postinst
    ${PROJECT_SOURCE_DIR}/packaging/debian/python3/prerm)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
    "${CPACK_PACKAGE_DESCRIPTION}\nThis package has the module for Python 3, with NumPy arrays.")

# install_compressed(COMPONENT FOLDER NAME TEXT)
function(install_compressed component folder name text)
    set(file ${CMAKE_BINARY_DIR}/debian-${component}/${name})
    file(WRITE ${file} "${text}")
    execute_process(COMMAND gzip -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
    install(FILES ${file}.gz DESTINATION ${folder} COMPONENT ${component})
endfunction()

file(READ LICENSE license)
file(READ packaging/debian/changelog changelog)
string(REPLACE "@VERSION@" ${version} changelog "${changelog}")
string(REPLACE "@CONTACT@" "${PLIANT_PACKAGE_CONTACT}" changelog "${changelog}")
file(READ packaging/debian/pliant.1 manual)
file(WRITE ${CMAKE_BINARY_DIR}/copyright "${license}")
foreach(component ${CPACK_COMPONENTS_ALL})
    string(TOUPPER ${component} name)
    set(folder share/doc/${CPACK_DEBIAN_${name}_PACKAGE_NAME})
    install(FILES ${CMAKE_BINARY_DIR}/copyright DESTINATION ${folder} COMPONENT ${component})
    install_compressed(${component} ${folder} changelog.Debian "${changelog}")
endforeach()
install_compressed(tools share/man/man1 pliant.1 "${manual}")
include(CPack)

# Parts that are built where the packages that they need are there. packages.txt says which package brings what.
find_package(PkgConfig REQUIRED)

# Sets RESULT to those of the pkg-config modules that are not there: "epoxy (Debian: libepoxy-dev), ...".
function(pliant_missing_modules result)
    file(STRINGS ${pliant_SOURCE_DIR}/cmake/packages.txt packages REGEX " module ")
    set(missing)
    foreach(module ${ARGN})
        pkg_check_modules(PLIANT_MODULE_${module} QUIET ${module})
        if(NOT PLIANT_MODULE_${module}_FOUND)
            set(package ${packages})
            list(FILTER package INCLUDE REGEX " module +${module}$")
            string(REGEX REPLACE " .*" "" package "${package}")
            list(APPEND missing "${module} (Debian: ${package})")
        endif()
    endforeach()
    list(JOIN missing ", " missing)
    set(${result} "${missing}" PARENT_SCOPE)
endfunction()

# pliant_part(OPTION DEFAULT WHAT): the setting of a part, AUTO, ON or OFF.
macro(pliant_part option default what)
    set(${option} ${default} CACHE STRING "Build ${what}: ON, OFF, or AUTO, where its packages are there")
    set_property(CACHE ${option} PROPERTY STRINGS AUTO ON OFF)
endmacro()

# pliant_part_needs(OPTION WHAT MODULE...): sets OPTION to whether the part is built. Where it is AUTO and modules are
# missing it is left out and that is said; where it is ON that is an error.
function(pliant_part_needs option what)
    if(NOT "${${option}}" STREQUAL "AUTO" AND NOT ${option})
        return()
    endif()
    pliant_missing_modules(missing ${ARGN})
    if(NOT missing)
        set(${option} ON PARENT_SCOPE)
    elseif("${${option}}" STREQUAL "AUTO")
        message(STATUS "Left out: ${what}. Missing: ${missing}")
        set(${option} OFF PARENT_SCOPE)
    else()
        message(FATAL_ERROR "${option}=${${option}}: ${what} needs ${missing}")
    endif()
endfunction()

# cmake -D NM= -D PROGRAM= -D LIBRARY= -D ALLOWED="body;world" -P check_symbols.cmake
#
# Lists the modules (object files) of the static library that left a global symbol in the program, and fails when one is
# not among ALLOWED, or when a symbol of any kind bears the name of a feature that nobody enabled.

cmake_minimum_required(VERSION 3.25)

set(forbidden_words aero pressure pose polar soft_contact collide_faces face_contact read_obj read_tetgen lattice
    triangle_mesh convex_hull)

function(run_nm output)
    execute_process(COMMAND ${NM} ${ARGN} OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        list(JOIN ARGN " " arguments)
        message(FATAL_ERROR "${NM} ${arguments} failed")
    endif()
    string(REPLACE "\n" ";" lines "${text}")
    set(${output} ${lines} PARENT_SCOPE)
endfunction()

# POSIX format: "name type [value size]".
run_nm(program_lines -P ${PROGRAM})
foreach(line IN LISTS program_lines)
    if(line MATCHES "^([^ ]+) ([A-Za-z])")
        set(name ${CMAKE_MATCH_1})
        if(CMAKE_MATCH_2 MATCHES "[A-TV-Z]")
            set(in_program_${name} TRUE)
        endif()
        foreach(word IN LISTS forbidden_words)
            if(name MATCHES "${word}")
                list(APPEND forbidden_symbols ${name})
            endif()
        endforeach()
    endif()
endforeach()

# "libpliant.a[body.c.o]:" before the symbols of each member.
run_nm(library_lines -P ${LIBRARY})
foreach(line IN LISTS library_lines)
    if(line MATCHES "\\[([^].]+)\\..*\\]:$")
        set(module ${CMAKE_MATCH_1})
    elseif(line MATCHES "^([^ ]+) [A-TV-Z] " AND in_program_${CMAKE_MATCH_1})
        list(APPEND modules ${module})
    endif()
endforeach()
list(REMOVE_DUPLICATES modules)
list(SORT modules)

if(NOT modules)
    message(FATAL_ERROR "no module of ${LIBRARY} found in ${PROGRAM}: the check sees nothing")
endif()
message(STATUS "linked modules: ${modules}")
set(extra ${modules})
list(REMOVE_ITEM extra ${ALLOWED})
if(extra)
    message(FATAL_ERROR "modules that the program does not use: ${extra}")
endif()
if(forbidden_symbols)
    message(FATAL_ERROR "symbols of features that nobody enabled: ${forbidden_symbols}")
endif()

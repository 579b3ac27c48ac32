# cmake -D NM= -D PROGRAM= -D LIBRARY= -D ALLOWED="body;world" -P check_symbols.cmake
#
# Lists the modules (object files) of the static library that left a global symbol in the program, and fails when one is
# not among ALLOWED, or when any symbol bears the name of a feature that the program did not enable.

cmake_minimum_required(VERSION 3.25)

set(forbidden_words aero pressure volume "(^|_)pose" polar anchor soft_contact face_contact read_obj
    read_tetgen lattice triangle_mesh sampled_mesh triangle_soup winding convex_hull convex_distance gjk penetration
    "^ccd" rotation_fit self_ spatial_hash
    crossings cluster "^joints?_" "^plii_joint" "(linear|angular)_joint" pair_cache refine "^plii_edit"
    "_cut_" "^cut_" "^pthread_" "^plii?_threads" "^threads_")
foreach(module IN LISTS ALLOWED) # what may be linked may be named
    foreach(word IN LISTS forbidden_words)
        if(module MATCHES "${word}")
            list(REMOVE_ITEM forbidden_words ${word})
        endif()
    endforeach()
endforeach()

function(run_nm output)
    execute_process(COMMAND ${NM} ${ARGN} OUTPUT_VARIABLE text ERROR_QUIET RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        list(JOIN ARGN " " arguments)
        message(FATAL_ERROR "${NM} ${arguments} failed")
    endif()
    string(REPLACE "\n" ";" lines "${text}")
    set(${output} ${lines} PARENT_SCOPE)
endfunction()

# POSIX format: "name type [value size]". Hidden symbols become local in a program, so case says nothing there.
run_nm(program_lines -P ${PROGRAM})
foreach(line IN LISTS program_lines)
    if(line MATCHES "^([^ ]+) [A-TV-Za-z] ")
        set(name ${CMAKE_MATCH_1})
        set(in_program_${name} TRUE)
        foreach(word IN LISTS forbidden_words)
            if(name MATCHES "${word}")
                list(APPEND forbidden_symbols ${name})
            endif()
        endforeach()
    endif()
endforeach()

# "libpliant.a[body.c.o]:" (GNU) or "body.c.o:" (LLVM) before the symbols of each member; upper case: global.
run_nm(library_lines -P ${LIBRARY})
foreach(line IN LISTS library_lines)
    if(line MATCHES "([A-Za-z0-9_]+)\\.c\\.o\\]?:$")
        set(module ${CMAKE_MATCH_1})
    elseif(line MATCHES "^([^ ]+) [A-TV-Z] ")
        set(name ${CMAKE_MATCH_1})
        if(NOT name MATCHES "^plii?_")
            message(FATAL_ERROR "${module} exports ${name}, a name without the prefix pli_ or plii_")
        endif()
        if(in_program_${name})
            list(APPEND modules ${module})
        endif()
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

# cmake -D ROOT=<source directory> -P check_includes.cmake
#
# Includes only point down: core <- bullet_bridge <- demos, bench. The core includes nothing but C's library and itself;
# its public headers nothing of its sources; the step knows no feature, and no feature knows another. Inside a layer they
# point down from room to room.

cmake_minimum_required(VERSION 3.25)

set(c_headers assert ctype errno fenv float inttypes limits locale math setjmp signal stdalign stdarg stdatomic stdbool stddef
    stdint stdio stdlib stdnoreturn string tgmath threads time)
set(ccd_modules convex_penetration) # the only ones that may read libccd
set(simd_modules simd_float4 simd_float8) # the only ones that may read headers of instruction sets
set(thread_modules threads) # the only ones that may read headers of POSIX threads
set(service_modules link_coloring link_graph substep_kinds) # features that only others need
set(step_modules body bounds context context_create feature mesh pipeline pbd_solver vec world) # what every program links
set(feature_headers anchor bullet_reference contact drag forces generate implicit io pliant pose self_collision target tether threads xpbd) # public headers that the step must not read

set(problems "")
function(problem file text)
    set(problems ${problems} "${file}: ${text}" PARENT_SCOPE)
endfunction()

# Includes of a file without <> and "", those in <> in `angle`, those in "" in `quoted`.
function(read_includes file)
    set(angle "")
    set(quoted "")
    file(STRINGS ${ROOT}/${file} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
        if(line MATCHES "<([^>]+)>")
            list(APPEND angle ${CMAKE_MATCH_1})
        elseif(line MATCHES "\"([^\"]+)\"")
            list(APPEND quoted ${CMAKE_MATCH_1})
        endif()
    endforeach()
    set(angle ${angle} PARENT_SCOPE)
    set(quoted ${quoted} PARENT_SCOPE)
endfunction()

function(list_files output)
    set(patterns "")
    foreach(directory IN LISTS ARGN)
        foreach(extension c h cpp hpp inc)
            list(APPEND patterns ${ROOT}/${directory}/*.${extension})
        endforeach()
    endforeach()
    file(GLOB_RECURSE files RELATIVE ${ROOT} ${patterns})
    set(${output} ${files} PARENT_SCOPE)
endfunction()

# ---- core
list_files(core_files core)
list_files(core_sources core/src)
set(feature_modules "")
foreach(file IN LISTS core_sources)
    cmake_path(GET file STEM stem)
    file(STRINGS ${ROOT}/${file} definition REGEX "^(static )?const plii_feature_class [a-z_]+ = ")
    if(definition)
        list(APPEND feature_modules ${stem})
    endif()
endforeach()
if(NOT feature_modules)
    problem(core/src "no feature found: the check sees nothing")
endif()

foreach(file IN LISTS core_files)
    cmake_path(GET file STEM stem)
    cmake_path(GET file EXTENSION extension)
    if(NOT extension MATCHES "^\\.(c|h)$")
        problem(${file} "the core is C")
    endif()
    set(is_public FALSE)
    if(file MATCHES "^core/include/")
        set(is_public TRUE)
    endif()
    read_includes(${file})
    foreach(name IN LISTS angle)
        string(REGEX REPLACE "\\.h$" "" base ${name})
        if(name MATCHES "^ccd/" AND stem IN_LIST ccd_modules)
            continue()
        elseif(name MATCHES "^(immintrin|emmintrin|arm_neon|wasm_simd128)\\.h$" AND stem IN_LIST simd_modules)
            continue()
        elseif(name MATCHES "^(pthread|sched)\\.h$" AND stem IN_LIST thread_modules)
            continue()
        elseif(NOT name MATCHES "\\.h$" OR NOT base IN_LIST c_headers)
            problem(${file} "<${name}> is not a header of C")
        endif()
    endforeach()
    foreach(name IN LISTS quoted)
        cmake_path(GET name STEM included)
        if(is_public)
            if(NOT EXISTS ${ROOT}/core/include/pliant/${name})
                problem(${file} "\"${name}\" is not a public header")
            endif()
        elseif(NOT EXISTS ${ROOT}/core/src/${name} AND NOT EXISTS ${ROOT}/core/include/${name})
            problem(${file} "\"${name}\" is not a header of the core")
        elseif(name MATCHES "^pliant/")
            if(stem IN_LIST step_modules AND included IN_LIST feature_headers)
                problem(${file} "the step includes \"${name}\", a feature")
            endif()
        elseif(included IN_LIST feature_modules AND NOT included IN_LIST service_modules AND NOT stem MATCHES "^${included}")
            problem(${file} "includes \"${name}\" of another feature")
        endif()
    endforeach()
endforeach()

# ---- bridge, demos, bench: own files and public headers of what lies below
function(check_layer layer)
    list_files(files ${layer})
    list_files(reachable ${ARGV})
    foreach(file IN LISTS files)
        read_includes(${file})
        foreach(name IN LISTS angle quoted)
            if(name MATCHES "core/src|bullet_bridge/src")
                problem(${file} "\"${name}\" is not a public header")
            endif()
        endforeach()
        foreach(name IN LISTS quoted)
            string(REGEX REPLACE "^(\\.\\./)+" "" pattern ${name})
            string(REPLACE "." "\\." pattern ${pattern})
            set(matches ${reachable})
            list(FILTER matches INCLUDE REGEX "/${pattern}$")
            if(NOT matches)
                problem(${file} "\"${name}\" does not lie in: ${ARGV}")
            endif()
        endforeach()
    endforeach()
    set(problems ${problems} PARENT_SCOPE)
endfunction()

check_layer(bullet_bridge core/include)
check_layer(demos bullet_bridge/include core/include)
check_layer(bench demos bullet_bridge/include core/include core/src) # it times services of the core on their own

# ---- rooms of a layer, from the ground up; see rooms.cmake
include(${CMAKE_CURRENT_LIST_DIR}/rooms.cmake)
set(bullet_bridge_rooms include/pliant_bullet src)
set(demos_rooms
    "description measure/reference random_calls hello_core hello_bullet hello_cape hello_features hello_kinds hello_migration hello_rollback hello_state hello_vehicle"
    "scenes engines report" # what a scene says, what runs it, and how figures are written know nothing of each other
    "measure render"
    "measure/stability measure/workprec viewer export"
    "app web")
set(core_rooms base math geometry "shape mesh" body "features contact" "self_collision cut cluster solver/coloring"
    "solver/pbd solver/implicit solver/xpbd" world file)
check_rooms(core/src ${core_rooms})
check_rooms(bullet_bridge ${bullet_bridge_rooms})
check_rooms(demos ${demos_rooms})

if(problems)
    list(JOIN problems "\n  " text)
    message(FATAL_ERROR "includes and rooms:\n  ${text}")
endif()
list(LENGTH core_files count)
message(STATUS "${count} files of the core checked, features: ${feature_modules}")

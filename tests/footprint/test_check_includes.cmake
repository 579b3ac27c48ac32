# cmake -D ROOT=<source directory> -D WORK=<folder> -P test_check_includes.cmake
#
# Plants faults in a copy of the sources, and looks whether check_includes.cmake finds each, and nothing without them.

cmake_minimum_required(VERSION 3.25)

file(REMOVE_RECURSE ${WORK})
foreach(layer core bullet_bridge demos bench)
    file(COPY ${ROOT}/${layer} DESTINATION ${WORK}
        FILES_MATCHING REGEX "\\.(c|h|cpp|hpp|inc|inl)$" PATTERN data EXCLUDE)
endforeach()

# expect(NAME MESSAGE): the check says something like MESSAGE, or passes where that is empty.
function(expect name message)
    execute_process(COMMAND ${CMAKE_COMMAND} -D ROOT=${WORK} -P ${CMAKE_CURRENT_LIST_DIR}/check_includes.cmake
        RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(message STREQUAL "" AND NOT result EQUAL 0)
        message(SEND_ERROR "${name}: the check fails:\n${output}")
    elseif(NOT message STREQUAL "" AND result EQUAL 0)
        message(SEND_ERROR "${name}: the check passes")
    elseif(NOT output MATCHES "${message}")
        message(SEND_ERROR "${name}: the check does not say \"${message}\":\n${output}")
    endif()
endfunction()

# plant(NAME MESSAGE FILE LINE [FILE LINE]...): with the lines at the ends of the files, which may be new.
function(plant name message)
    set(places ${ARGN})
    while(places)
        list(POP_FRONT places file line)
        file(APPEND ${WORK}/${file} "${line}\n")
        list(APPEND planted ${file})
    endwhile()
    expect(${name} "${message}")
    foreach(file IN LISTS planted)
        if(EXISTS ${ROOT}/${file})
            file(COPY_FILE ${ROOT}/${file} ${WORK}/${file})
        else()
            file(REMOVE ${WORK}/${file})
        endif()
    endforeach()
endfunction()

expect("the tree" "")
plant("circle of headers" "demos: circle: report/[a-z]+ -> report/[a-z]+ -> report/[a-z]+"
    demos/report/svg.h "#include \"table.h\""
    demos/report/table.h "#include \"svg.h\"")
plant("circle by a source" "demos: circle: report/[a-z]+ -> report/[a-z]+ -> report/[a-z]+"
    demos/report/svg.cpp "#include \"table.h\""
    demos/report/table.h "#include \"svg.h\"")
plant("circle in the bridge" "bullet_bridge: circle: src/[a-z_/]+ -> src/[a-z_/]+"
    bullet_bridge/src/convert.h "#include \"shapes/triangle_copy.h\"")
plant("circle in the core" "core/src: circle: "
    core/src/math/vec.h "#include \"planted.h\""
    core/src/math/planted.h "#include \"vec.h\"")
plant("arrow upwards in the core" "core/src/math/vec.h: \"geometry/gjk.h\" lies in geometry, which is not below math"
    core/src/math/vec.h "#include \"geometry/gjk.h\"")
plant("arrow upwards" "demos/scenes/scenes.h: \"app/commands.h\" lies in app, which is not below scenes"
    demos/scenes/scenes.h "#include \"app/commands.h\"")
plant("arrow to a neighbour" "\"engines/stopwatch.h\" lies in engines, which is not below report"
    demos/report/csv.cpp "#include \"engines/stopwatch.h\"")
plant("file without a room" "demos/loose.h: lies in no room"
    demos/loose.h "// empty")
plant("source of the bridge in the program" "is not a public header"
    demos/engines/controls.cpp "#include \"../../bullet_bridge/src/convert.h\"")
string(REPEAT "\n" 600 lines)
plant("long file" "demos/report/long.h: 601 lines, at most 600"
    demos/report/long.h "${lines}")
foreach(i RANGE 30)
    list(APPEND files demos/report/more_${i}.h "// empty")
endforeach()
plant("full folder" "demos/report: [0-9]+ entries, at most 30" ${files})
expect("the tree again" "")

# cmake -D NM= -D SIZE= -D OBJECTS="a.c.o;b.c.o" -D SOURCES= -D OUTPUT= -P core_modules.cmake
#
# Writes what the core consists of, from its object files: bytes of each module (one per source file), which modules it
# cannot be linked without, which public function is in which module, and which feature. In a unity build several sources
# are one module, without features.

cmake_minimum_required(VERSION 3.25)

function(run output)
    execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE text RESULT_VARIABLE result)
    if(NOT result EQUAL 0)
        message(FATAL_ERROR "${ARGV1} failed")
    endif()
    string(REPLACE "\n" ";" lines "${text}")
    set(${output} ${lines} PARENT_SCOPE)
endfunction()

# "   text   data   bss   dec   hex   filename"
run(size_lines ${SIZE} ${OBJECTS})
foreach(line IN LISTS size_lines)
    if(line MATCHES "^ *([0-9]+)[ \t]+([0-9]+)[ \t]+([0-9]+)[ \t].*[/ \t]([A-Za-z0-9_]+)\\.c\\.o$")
        set(name ${CMAKE_MATCH_4})
        math(EXPR bytes "${CMAKE_MATCH_1} + ${CMAKE_MATCH_2} + ${CMAKE_MATCH_3}")
        list(APPEND modules ${name})
        string(APPEND module_text "    {\"${name}\", ${bytes}},\n")
    endif()
endforeach()
list(LENGTH OBJECTS object_count)
list(LENGTH modules module_count)
if(NOT object_count EQUAL module_count)
    message(FATAL_ERROR "${module_count} sizes of ${object_count} object files")
endif()

# POSIX format with the file before it: "path/a.c.o: name type [value size]". Upper case: global; U: not defined here.
run(symbol_lines ${NM} -P -A ${OBJECTS})
foreach(line IN LISTS symbol_lines)
    if(line MATCHES "([A-Za-z0-9_]+)\\.c\\.o\\]?: ([^ ]+) U")
        list(APPEND wanted_${CMAKE_MATCH_1} ${CMAKE_MATCH_2})
    elseif(line MATCHES "([A-Za-z0-9_]+)\\.c\\.o\\]?: ([^ ]+) ([A-TV-Z]) ")
        set(module ${CMAKE_MATCH_1})
        set(name ${CMAKE_MATCH_2})
        set(type ${CMAKE_MATCH_3})
        set(home_${name} ${module})
        if(name MATCHES "^pli_" AND type STREQUAL "T")
            string(APPEND function_text "    {\"${name}\", \"${module}\"},\n")
        endif()
    endif()
endforeach()
foreach(module IN LISTS modules)
    set(needed)
    foreach(name IN LISTS wanted_${module})
        if(home_${name})
            list(APPEND needed ${home_${name}})
        endif()
    endforeach()
    list(REMOVE_DUPLICATES needed)
    foreach(other IN LISTS needed)
        string(APPEND need_text "    {\"${other}\", \"${module}\"},\n")
    endforeach()

    file(GLOB_RECURSE source_file ${SOURCES}/${module}.c)
    if(NOT source_file)
        continue()
    endif()
    file(READ ${source_file} source)
    string(REPLACE ";" "," source "${source}")
    string(REGEX MATCHALL "plii_feature_class [a-z_]+ = {[ \n]*\\.name = \"[^\"]+\"" features "${source}")
    foreach(feature IN LISTS features)
        string(REGEX REPLACE ".*\"([^\"]+)\"" "\\1" name "${feature}")
        string(APPEND feature_text "    {\"${name}\", \"${module}\"},\n")
    endforeach()
endforeach()
file(WRITE ${OUTPUT} "// Written by core_modules.cmake.
#include \"core_module_table.h\"

namespace demos {

const std::vector<CoreModule> core_modules{
${module_text}};
const std::vector<CoreEntry> core_needs{
${need_text}};
const std::vector<CoreEntry> core_functions{
${function_text}};
const std::vector<CoreEntry> core_feature_modules{
${feature_text}};

} // namespace demos
")

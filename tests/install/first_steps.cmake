# cmake -D SOURCE= -D WORK= -P first_steps.cmake: the first steps of docs/building.md and docs/manual/start_c.md, as they
# stand there, on a machine that has the packages named there.
file(REMOVE_RECURSE ${WORK})
find_program(PKG_CONFIG pkg-config REQUIRED)
foreach(module ccd bullet)
    execute_process(COMMAND ${PKG_CONFIG} --variable=pcfiledir ${module} OUTPUT_VARIABLE directory
        OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    file(COPY ${directory}/${module}.pc DESTINATION ${WORK}/pkgconfig)
endforeach()
set(ENV{PKG_CONFIG_LIBDIR} ${WORK}/pkgconfig)
set(ENV{PKG_CONFIG_PATH})
# Compiles faster.
file(WRITE ${WORK}/quick.cmake "set(CMAKE_UNITY_BUILD ON)\nset(CMAKE_UNITY_BUILD_BATCH_SIZE 0)\n")
set(ENV{CMAKE_TOOLCHAIN_FILE} ${WORK}/quick.cmake)
set(ENV{CMAKE_BUILD_TYPE} Debug)

# The first block of a page in a language.
function(read_block document language result)
    file(READ ${SOURCE}/docs/${document} page)
    string(FIND "${page}" "```${language}\n" begin)
    string(SUBSTRING "${page}" ${begin} -1 page)
    string(FIND "${page}" "\n" begin)
    math(EXPR begin "${begin} + 1")
    string(SUBSTRING "${page}" ${begin} -1 page)
    string(FIND "${page}" "```" length)
    string(SUBSTRING "${page}" 0 ${length} page)
    set(${result} "${page}" PARENT_SCOPE)
endfunction()

# Of text, which may have semicolons.
function(count_lines text result)
    string(REGEX REPLACE "[^\n]" "" newlines "${text}")
    string(LENGTH "${newlines}" count)
    set(${result} ${count} PARENT_SCOPE)
endfunction()

read_block(building.md sh commands)
read_block(building.md cmake lists)
read_block(building.md cpp program)
count_lines("${commands}" command_count)
count_lines("${program}" line_count)
if(command_count GREATER 10 OR line_count GREATER 40)
    message(FATAL_ERROR "${command_count} commands for 10, ${line_count} lines for 40")
endif()
file(WRITE ${WORK}/game/CMakeLists.txt "${lists}")
file(WRITE ${WORK}/game/main.cpp "${program}")
file(CREATE_LINK ${SOURCE} ${WORK}/pliant SYMBOLIC)

# Runs what a page says and compares the end of what is printed.
function(run_commands page commands expected)
    string(REGEX REPLACE "^apt-get[^\n]*\n" "" commands "${commands}")
    execute_process(COMMAND sh -e -c "${commands}" WORKING_DIRECTORY ${WORK} OUTPUT_VARIABLE out ERROR_VARIABLE out
        RESULT_VARIABLE status)
    if(NOT status EQUAL 0 OR NOT out MATCHES "${expected}\n$")
        message(FATAL_ERROR "docs/${page}: status ${status}\n${out}")
    endif()
endfunction()

run_commands(building.md "${commands}" "top of the cloth: 0\\.[56][0-9] m")

# The same folders, so that nothing is built twice.
read_block(manual/start_c.md sh commands)
run_commands(manual/start_c.md "${commands}" "corner after 1\\.5 s: y = -0\\.5[0-9] m")

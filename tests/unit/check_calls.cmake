# Every public function that takes a handle is in the list of all_calls.h.
# cmake -DHEADERS=core/include/pliant -DLIST=tests/unit/all_calls.h -P check_calls.cmake

cmake_minimum_required(VERSION 3.25)

set(without_handle pli_status_string pli_context_create)
set(tested_by_themselves pli_last_error pli_threads_create pli_threads_destroy pli_threads_count
    pli_threads_parallel_for) # a pool belongs to no context

file(READ ${LIST} list)
file(GLOB headers ${HEADERS}/*.h)
set(missing "")
set(count 0)
foreach(header ${headers})
    file(READ ${header} text)
    string(REGEX MATCHALL "PLI_API [a-z0-9_ *]*[ *]pli_[a-z0-9_]+\\(" declarations "${text}")
    foreach(declaration ${declarations})
        string(REGEX REPLACE ".*(pli_[a-z0-9_]+)\\($" "\\1" name "${declaration}")
        if(name MATCHES "_def_default$" OR name IN_LIST without_handle OR name IN_LIST tested_by_themselves)
            continue()
        endif()
        math(EXPR count "${count} + 1")
        string(FIND "${list}" "X(${name}, " place)
        if(place EQUAL -1)
            list(APPEND missing ${name})
        endif()
    endforeach()
endforeach()
if(count LESS 150)
    message(FATAL_ERROR "only ${count} functions found in ${HEADERS}")
endif()
if(missing)
    message(FATAL_ERROR "not in ${LIST}: ${missing}")
endif()
message(STATUS "${count} functions are listed")

# cmake -D BUILD=<build directory> -D PREFIX=<where to> -D CONFIG= -P install.cmake: a fresh installation.
unset(ENV{DESTDIR})
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --config "${CONFIG}"
    COMMAND_ERROR_IS_FATAL ANY)

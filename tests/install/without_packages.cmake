# cmake -D SOURCE= -D BUILD= -D CONSUMER= -D PREFIX= -D GENERATOR= -P without_packages.cmake: configures on a machine
# where pkg-config finds libccd only, first the project and then one that uses its installation.
file(REMOVE_RECURSE ${BUILD})
find_program(PKG_CONFIG pkg-config REQUIRED)
execute_process(COMMAND ${PKG_CONFIG} --variable=pcfiledir ccd OUTPUT_VARIABLE directory
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
file(COPY ${directory}/ccd.pc DESTINATION ${BUILD}/pkgconfig)
set(ENV{PKG_CONFIG_LIBDIR} ${BUILD}/pkgconfig)
set(ENV{PKG_CONFIG_PATH})

# configure(SOURCE RESULT STATUS [SETTING...])
function(configure source name settings)
    execute_process(COMMAND ${CMAKE_COMMAND} -S ${source} -B ${BUILD}/${name} -G ${GENERATOR} ${settings}
        OUTPUT_VARIABLE out ERROR_VARIABLE out RESULT_VARIABLE status)
    set(out "${out}" PARENT_SCOPE)
    set(status ${status} PARENT_SCOPE)
endfunction()

function(expect condition text)
    if(NOT status ${condition} 0 OR NOT out MATCHES "${text}")
        message(FATAL_ERROR "expected status ${condition} 0 and \"${text}\", got ${status} and\n${out}")
    endif()
endfunction()

configure(${SOURCE} project "")
expect(EQUAL "Left out: the bridge to Bullet. Missing: bullet \\(Debian: libbullet-dev\\)")
expect(EQUAL "Left out: the tests. Missing: cmocka \\(Debian: libcmocka-dev\\)")
expect(EQUAL "Left out: the program pliant. Missing: [^\n]*epoxy \\(Debian: libepoxy-dev\\)")

configure(${SOURCE} insisted -DPLIANT_BUILD_BRIDGE=ON)
expect(GREATER "PLIANT_BUILD_BRIDGE=ON: the bridge to Bullet needs bullet \\(Debian:")

configure(${CONSUMER} consumer "-DHOW=find_package;-DWITH_BULLET=OFF;-DCMAKE_PREFIX_PATH=${PREFIX}")
expect(EQUAL "Pliant without pliant::bullet: pkg-config does not find bullet[^\n]*\\(Debian: libbullet-dev\\)")

file(WRITE ${BUILD}/core/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(core C)
find_package(pliant REQUIRED COMPONENTS core)
")
configure(${BUILD}/core wrong -DCMAKE_PREFIX_PATH=${PREFIX})
expect(GREATER "there is no component core")

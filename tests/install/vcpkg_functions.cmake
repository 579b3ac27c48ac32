# What the port calls of vcpkg, as far as it is needed to run it without vcpkg: BUILD, the folder to work in; FEATURES.
cmake_minimum_required(VERSION 3.25)
set(CURRENT_PACKAGES_DIR ${BUILD}/packages)

function(vcpkg_check_features)
    cmake_parse_arguments(PARSE_ARGV 0 ARG "" "OUT_FEATURE_OPTIONS" "FEATURES")
    set(options)
    while(ARG_FEATURES)
        list(POP_FRONT ARG_FEATURES feature setting)
        set(value OFF)
        if(feature IN_LIST FEATURES)
            set(value ON)
        endif()
        list(APPEND options -D${setting}=${value})
    endwhile()
    set(${ARG_OUT_FEATURE_OPTIONS} ${options} PARENT_SCOPE)
endfunction()

function(vcpkg_find_acquire_program name)
    find_program(program pkg-config REQUIRED)
    set(${name} ${program} PARENT_SCOPE)
endfunction()

function(vcpkg_cmake_configure)
    cmake_parse_arguments(PARSE_ARGV 0 ARG "" "SOURCE_PATH" "OPTIONS")
    execute_process(COMMAND ${CMAKE_COMMAND} -S ${ARG_SOURCE_PATH} -B ${BUILD}/build -G Ninja -DCMAKE_BUILD_TYPE=Debug
        -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=0 -DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR} -DCMAKE_INSTALL_LIBDIR=lib ${ARG_OPTIONS}
        OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(vcpkg_cmake_install)
    execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD}/build --target install OUTPUT_QUIET
        COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(expect_file path)
    if(NOT EXISTS ${path})
        message(FATAL_ERROR "the port has not made ${path}")
    endif()
endfunction()

function(vcpkg_cmake_config_fixup)
    cmake_parse_arguments(PARSE_ARGV 0 ARG "" "CONFIG_PATH" "")
    expect_file(${CURRENT_PACKAGES_DIR}/${ARG_CONFIG_PATH}/pliant-config.cmake)
endfunction()

function(vcpkg_fixup_pkgconfig)
    expect_file(${CURRENT_PACKAGES_DIR}/lib/pkgconfig/pliant.pc)
endfunction()

function(vcpkg_install_copyright)
    cmake_parse_arguments(PARSE_ARGV 0 ARG "" "" "FILE_LIST")
    expect_file(${ARG_FILE_LIST})
endfunction()

include(${PORT})
expect_file(${CURRENT_PACKAGES_DIR}/lib/libpliant.a)

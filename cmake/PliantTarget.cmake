# Checks of undefined behaviour that take two fifths of the time to compile C++. In demos and tests they are left out: memory
# that is not there, AddressSanitizer finds.
set(PLIANT_SLOW_CHECKS null,alignment,vptr,object-size)

# Settings shared by all targets of this project: language standard, warnings, sanitizers, reproducible arithmetic.
function(pliant_target target)
    target_compile_features(${target} PRIVATE c_std_17)
    if(CMAKE_CXX_COMPILER)
        target_compile_features(${target} PRIVATE cxx_std_17)
    endif()
    set_target_properties(${target} PROPERTIES C_EXTENSIONS OFF CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON
        C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden)
    # Contraction of a*b+c to a fused operation would make results depend on compiler and target.
    target_compile_options(${target} PRIVATE -ffp-contract=off -ffunction-sections -fdata-sections -fno-math-errno
        -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef
        $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes -Wstrict-prototypes -Wold-style-definition>)
    if(PLIANT_WERROR)
        target_compile_options(${target} PRIVATE -Werror)
    endif()
    if(PLIANT_SANITIZE)
        target_compile_options(${target} PRIVATE -fsanitize=${PLIANT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
        if(PLIANT_UNCHECKED_CXX)
            target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize=${PLIANT_UNCHECKED_CXX}>)
        endif()
        target_link_options(${target} PUBLIC -fsanitize=${PLIANT_SANITIZE})
    endif()
    if(PLIANT_FUZZ)
        target_compile_options(${target} PRIVATE -fsanitize=fuzzer-no-link)
    endif()
endfunction()

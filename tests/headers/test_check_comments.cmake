# cmake -D CHECK=check_comments.cmake -D SCRATCH=<directory> -P test_check_comments.cmake
#
# What check_comments.cmake finds in a header in which everything has its comment but for one line.

cmake_minimum_required(VERSION 3.25)

set(good [[
/// What a ray may hit; bits.
enum {
    PLI_PLANTED_NODES = 1, ///< spheres
    PLI_PLANTED_LINKS = 2  ///< capsules
};

/// How much.
typedef enum pli_planted_kind {
    /// Little, [0, 1).
    PLI_PLANTED_LITTLE = 0,
    PLI_PLANTED_MUCH ///< (1, 2]
} pli_planted_kind;

/// Asked for.
typedef struct pli_planted_def {
    float size;     ///< m, > 0; its
                    ///< default is 1
    /// A function; none by default.
    void (*surface)(int count, const float* points,
                    void* user);
    uint32_t cookie; ///< set by the default function
} pli_planted_def;

/// Handed over.
class PLI_API Planted {
public:
    /// Makes one.
    explicit Planted(int number);
    Planted(const Planted&) = delete;
    /// The number.
    int number() const;

    class Impl;

private:
    int number_;
};

/// Defaults.
PLI_API pli_planted_def pli_planted_def_default(void);

/// Goes through [0, count).
/// @param count >= 0
PLI_API pli_status pli_planted_run(int count,
                                   const pli_planted_def* def);
]])

# run_check(TEXT EXPECTED): EXPECTED is empty or what the message has to name.
function(run_check text expected)
    file(REMOVE_RECURSE ${SCRATCH})
    file(WRITE ${SCRATCH}/planted.h "${text}")
    execute_process(COMMAND ${CMAKE_COMMAND} -D HEADERS=${SCRATCH} ${ARGN} -P ${CHECK}
        RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(expected STREQUAL "" AND NOT result EQUAL 0)
        message(FATAL_ERROR "refused although it is complete:\n${output}")
    elseif(NOT expected STREQUAL "")
        string(FIND "${output}" "${expected}" place)
        if(result EQUAL 0 OR place EQUAL -1)
            message(FATAL_ERROR "\"${expected}\" was not found:\n${output}")
        endif()
    endif()
endfunction()

run_check("${good}" "")
run_check("${good}" "too little" -D LEAST=12)

foreach(comment "/// Defaults.\n" "/// Goes through [0, count).\n/// @param count >= 0\n" "    /// Little, [0, 1).\n" " ///< (1, 2]"
        " ///< capsules" "    /// A function; none by default.\n" " ///< m, > 0; its\n                    ///< default is 1"
        " ///< set by the default function" "    /// Makes one.\n" "    /// The number.\n")
    string(FIND "${good}" "${comment}" place)
    if(place EQUAL -1)
        message(FATAL_ERROR "the header has no \"${comment}\"")
    endif()
    string(REPLACE "${comment}" "" planted "${good}")
    run_check("${planted}" "without a comment")
endforeach()

# A comment above two functions is that of the first.
string(REPLACE "(void);\n\n/// Goes through [0, count).\n/// @param count >= 0\n" "(void);\n" planted "${good}")
run_check("${planted}" "pli_planted_run")

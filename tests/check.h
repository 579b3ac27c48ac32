#ifndef TESTS_CHECK_H
#define TESTS_CHECK_H

/* cmocka with the headers it wants, and checks on floats that print what was measured. For C and C++. */

#ifdef __cplusplus
extern "C" {
#endif
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#ifdef __cplusplus
}
#endif

#include <math.h>

#define check_near(actual, expected, tolerance)                                                                        \
    do {                                                                                                               \
        const double check_actual = (double)(actual), check_expected = (double)(expected);                             \
        if (!(fabs(check_actual - check_expected) <= (double)(tolerance))) {                                           \
            fail_msg("%s = %.9g, expected %s = %.9g within %.3g", #actual, check_actual, #expected, check_expected,    \
                     (double)(tolerance));                                                                             \
        }                                                                                                              \
    } while (0)

#define check_at_most(actual, limit)                                                                                   \
    do {                                                                                                               \
        const double check_actual = (double)(actual), check_limit = (double)(limit);                                   \
        if (!(check_actual <= check_limit)) {                                                                          \
            fail_msg("%s = %.9g, at most %.9g wanted", #actual, check_actual, check_limit);                            \
        }                                                                                                              \
    } while (0)

#endif

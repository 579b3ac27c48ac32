/* Check of caller-given orders. */

#include "permutation.h"

#include <string.h>

pli_status plii_check_permutation(pli_context* context, const int* order, int count, uint8_t* marks,
                                  const char* function) {
    if (count > 0) { memset(marks, 0, (size_t)count); }
    for (int i = 0; i < count; ++i) {
        if (order[i] < 0 || order[i] >= count) {
            return plii_fail(context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                             "order[%d] is %d, out of range, there are %d contacts", i, order[i], count);
        }
        if (marks[order[i]] != 0) {
            return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "order[%d] names %d for the second time", i,
                             order[i]);
        }
        marks[order[i]] = 1;
    }
    return PLI_OK;
}

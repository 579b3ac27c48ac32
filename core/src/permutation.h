#ifndef PLII_PERMUTATION_H
#define PLII_PERMUTATION_H

#include "context.h"

/* PLI_OK when `order` names each of 0 .. count - 1 once. `marks` [count] is overwritten. */
pli_status plii_check_permutation(pli_context* context, const int* order, int count, uint8_t* marks,
                                  const char* function);

#endif

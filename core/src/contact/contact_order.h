#pragma once

/* Orders of contacts that the caller gives, for comparisons with engines that solve in another order. */

#include "body/feature.h"

/* Of a feature whose first array are its contacts: contact `order[i]` comes to place i. Fails, with the contacts as
   they were, when the feature is not enabled, when the body's world is not between predict and solve, or when `order`
   does not name each of them once. Messages name `function`. */
pli_status plii_reorder_contacts(pli_body* body, const plii_feature_class* klass, const int* order, int count,
                                 const char* function);

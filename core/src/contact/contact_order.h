#pragma once

/* Orders of contacts that the caller gives, for comparisons with engines that solve in another order. */

#include "base/context.h"
#include "pliant/body.h"

/* Contact `order[i]` comes to place i. `contacts` is an array of `contact_count` records of `contact_size` bytes.
   Fails, with the contacts as they were, when the body's world is not between predict and solve or when `order` does
   not name each of 0 .. contact_count - 1 once. Messages name `function`. */
pli_status plii_reorder_contacts(pli_body* body, void* contacts, size_t contact_size, int contact_count,
                                 const int* order, int count, const char* function);

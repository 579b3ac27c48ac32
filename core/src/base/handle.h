#pragma once

/* Handles that the user holds: the blocks behind them, and whether what a call was given is one.

   A handle is a pointer to a struct that begins with a magic number of its kind. In a checked build (PLIANT_CHECKED) a
   register of all handles of the process is asked instead, so that nothing is read that may be gone; and a new handle
   is not placed where another one was a short time ago. */

#include "base/context.h"

static inline uint32_t plii_handle_magic(plii_handle_kind kind) {
    return 0x706c6800u + (uint32_t)kind;
}

/* A zeroed block with its magic number, which is counted as alive in the context; NULL when out of memory. */
void* plii_handle_create(pli_context* context, plii_handle_kind kind, size_t size);
/* No call takes the handle any more; its block stays. */
void plii_handle_retire(void* handle);
/* Retires the handle, and gives its block back. */
void plii_handle_release(pli_context* context, void* handle, plii_handle_kind kind, size_t size);

/* Of a context, whose block is not its own. False when out of memory. */
bool plii_handle_add_context(pli_context* context);

#if PLIANT_CHECKED
bool plii_handle_is_alive(const void* handle, plii_handle_kind kind);
#else
static inline bool plii_handle_is_alive(const void* handle, plii_handle_kind kind) {
    return handle != NULL && *(const uint32_t*)handle == plii_handle_magic(kind);
}
#endif

/* The error of what is not a handle of this kind: PLI_ERROR_NULL_ARGUMENT, else PLI_ERROR_STALE_ID. `what` names it in
   the message, as "shape 2"; NULL: by its kind. The message goes to `context`, or, when that is NULL, to the context
   that the handle was made in; when that is gone or not known, to where pli_last_error(NULL) reads. */
PLII_COLD pli_status plii_handle_refuse(const void* handle, plii_handle_kind kind, pli_context* context,
                                        const char* what, const char* function);

static inline pli_status plii_check_handle(const void* handle, plii_handle_kind kind, pli_context* context,
                                           const char* what, const char* function) {
    return plii_handle_is_alive(handle, kind) ? PLI_OK : plii_handle_refuse(handle, kind, context, what, function);
}

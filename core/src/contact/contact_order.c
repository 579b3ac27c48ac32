/* Permutes contacts through a copy. */

#include "body/contact_report.h"
#include "body/pipeline.h"

static pli_status order_check(pli_context* context, const int* order, int count, uint8_t* marks, const char* function) {
    for (int i = 0; i < count; ++i) {
        PLII_FAIL_IF(order[i] < 0 || order[i] >= count, context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                     "order[%d] is %d, out of range, there are %d contacts", i, order[i], count);
        PLII_FAIL_IF(marks[order[i]] != 0, context, PLI_ERROR_INVALID_VALUE, function,
                     "order[%d] names %d for the second time", i, order[i]);
        marks[order[i]] = 1;
    }
    return PLI_OK;
}

pli_status plii_reorder_contacts(pli_body* body, const plii_feature_class* klass, const int* order, int count,
                                 const char* function) {
    PLII_TRY(plii_check_body_change(body, function));
    pli_context* context = body->context;
    const void* state = plii_feature_state(body, klass);
    PLII_FAIL_IF(state == NULL, context, PLI_ERROR_WRONG_STATE, function, "%s are not enabled", klass->name);
    const size_t contact_size = klass->arrays->element_size;
    const int contact_count = *(const int*)((const char*)state + klass->arrays->count);
    char* contacts = plii_feature_array_address(body, klass->arrays, state);
    PLII_FAIL_IF(!body->world->is_stepping, context, PLI_ERROR_WRONG_STATE, function,
                 "only allowed between collide and solve");
    PLII_FAIL_IF(count != contact_count, context, PLI_ERROR_INVALID_VALUE, function,
                 "count is %d, there are %d contacts", count, contact_count);
    if (count == 0) { return PLI_OK; }
    if (order == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "order is null"); }
    plii_scratch scratch = {.context = context};
    uint8_t* marks = PLII_TAKE(&scratch, uint8_t, count);
    char* copy = plii_scratch_take(&scratch, (size_t)count * contact_size);
    const pli_status status = scratch.is_short ? plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function,
                                                           "no memory to reorder %d contacts", count)
                                               : order_check(context, order, count, marks, function);
    if (status == PLI_OK) { memcpy(copy, contacts, (size_t)count * contact_size); }
    for (int i = 0; status == PLI_OK && i < count; ++i) {
        memcpy(contacts + (size_t)i * contact_size, copy + (size_t)order[i] * contact_size, contact_size);
    }
    plii_scratch_free(&scratch);
    return plii_body_changed(body, status);
}

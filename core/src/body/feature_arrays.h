#pragma once

/* The arrays that a feature declares: allocating, counting and releasing them, and letting them follow a cut. */

#include "body/feature.h"

/* All or none; zeroed. */
bool plii_feature_arrays_allocate(pli_body* body, const plii_feature_class* klass, void* state);
void plii_feature_arrays_release(pli_body* body, const plii_feature_class* klass, void* state);
void plii_feature_arrays_release_scratch(pli_body* body, const plii_feature_class* klass, void* state);
size_t plii_feature_arrays_bytes(const pli_body* body, const plii_feature_class* klass, const void* state);
/* Of one array: bytes that it has now, and where it is; NULL when it is not there. */
size_t plii_feature_array_bytes(const pli_body* body, const plii_feature_array* array, const void* state);
void* plii_feature_array_address(const pli_body* body, const plii_feature_array* array, const void* state);
/* An optional one that is not there; zeroed. False when out of memory, or of no size. */
bool plii_feature_array_add(pli_body* body, const plii_feature_array* array, void* state);
/* Whether it has lists with contents that have to follow a cut. */
bool plii_feature_arrays_need_commit(const plii_feature_class* klass);

/* For a change of topology: sizes of the new arrays; 0 for what does not follow the body. */
int plii_feature_arrays_sizes(const pli_body* body, const plii_feature_class* klass, const void* state,
                              const plii_topology_change* change, size_t* sizes);
/* Exchanges the arrays with new ones; `blocks` holds the old ones then. Contents go along where they are kept. */
void plii_feature_arrays_exchange(pli_body* body, const plii_feature_class* klass, void* state,
                                  const plii_topology_change* change, void** blocks);
/* Releases the old ones, and scratch. */
void plii_feature_arrays_drop(pli_body* body, const plii_feature_class* klass, void* state,
                              const plii_topology_change* change, void** blocks);

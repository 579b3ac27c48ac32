#ifndef PLII_LINK_RUNS_KERNEL_H
#define PLII_LINK_RUNS_KERNEL_H

/* What kernels over runs have in common: the nodes of a group, in records and in planes. The including file has chosen
   the instruction set. Callers give steps and turns as constants. */

#include "link_runs.h"
#include "node_planes.h"
#include "simd.h"

/* How the nodes of a group lie: see plii_link_run. */
typedef struct plii_run_form {
    ptrdiff_t offset;
    int step, turns; /* the offset where nodes take turns, else 0 */
} plii_run_form;

PLII_SIMD_INLINE ptrdiff_t plii_run_way(plii_run_form form) {
    return form.turns != 0 ? 2 * PLII_LINK_LANES : form.step * PLII_LINK_LANES;
}

/* First nodes of links, and the others. */
typedef struct plii_run_records {
    plii_packed8 a, b;
} plii_run_records;

PLII_SIMD_INLINE plii_run_records plii_run_load(const pli_vec4* first, plii_run_form form) {
    plii_run_records nodes;
    if (form.turns != 0) {
        plii_packed8_load_turns(first, form.turns, &nodes.a, &nodes.b);
    } else {
        nodes =
            (plii_run_records){plii_packed8_load(first, form.step), plii_packed8_load(first + form.offset, form.step)};
    }
    return nodes;
}
PLII_SIMD_INLINE void plii_run_store(pli_vec4* first, plii_run_form form, plii_run_records nodes) {
    if (form.turns != 0) {
        plii_packed8_store_turns(first, form.turns, nodes.a, nodes.b);
    } else {
        plii_packed8_store(first, form.step, nodes.a);
        plii_packed8_store(first + form.offset, form.step, nodes.b);
    }
}

/* One component of both. With step 2 the nodes between go along unchanged. */
typedef struct plii_run_numbers {
    plii_float8 a, b, between_a, between_b;
} plii_run_numbers;

PLII_SIMD_INLINE plii_run_numbers plii_run_load_plane(const float* first, plii_run_form form) {
    plii_run_numbers numbers;
    if (form.turns != 0) {
        plii_float8_load_turns(first, form.turns, &numbers.a, &numbers.b);
    } else if (form.step == 2) {
        plii_float8_load_second(first, &numbers.a, &numbers.between_a);
        plii_float8_load_second(first + form.offset, &numbers.b, &numbers.between_b);
        return numbers;
    } else {
        numbers.a = plii_float8_load(first);
        numbers.b = plii_float8_load(first + form.offset);
    }
    numbers.between_a = numbers.between_b = numbers.a; /* nobody reads them */
    return numbers;
}
PLII_SIMD_INLINE void plii_run_store_plane(float* first, plii_run_form form, plii_run_numbers numbers) {
    if (form.turns != 0) {
        plii_float8_store_turns(first, form.turns, numbers.a, numbers.b);
    } else if (form.step == 2) {
        plii_float8_store_second(first, numbers.a, numbers.between_a);
        plii_float8_store_second(first + form.offset, numbers.b, numbers.between_b);
    } else {
        plii_float8_store(first, numbers.a);
        plii_float8_store(first + form.offset, numbers.b);
    }
}
/* b - a */
PLII_SIMD_INLINE plii_float8 plii_run_difference(plii_run_numbers numbers) {
    return plii_float8_sub(numbers.b, numbers.a);
}
/* a - delta move_a, b + delta move_b */
PLII_SIMD_INLINE plii_run_numbers plii_run_moved(plii_run_numbers numbers, plii_float8 delta, plii_float8 move_a,
                                                 plii_float8 move_b) {
    numbers.a = plii_float8_sub(numbers.a, plii_float8_mul(delta, move_a));
    numbers.b = plii_float8_add(numbers.b, plii_float8_mul(delta, move_b));
    return numbers;
}
/* Numbers by slot in the order of planes. */
PLII_SIMD_INLINE plii_float8 plii_run_load_slots(const float* slots, plii_run_form form) {
    return plii_float8_load_slots(slots, form.turns != 0 || form.step == 2);
}

#endif

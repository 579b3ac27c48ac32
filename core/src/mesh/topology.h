#pragma once

/* What bodies share with their mesh. */

#include "base/context.h"

enum { PLII_MAX_MATERIALS = 0x8000 };

/* Faces and tetrahedra never change while bodies step, so bodies of one mesh share them. */
typedef struct plii_topology {
    int reference_count;
    int face_count, tetra_count;
    int (*faces)[3];
    uint16_t* face_materials; /* [face_count], or NULL when all are 0 */
    int (*tetras)[4];
} plii_topology;

/* With one reference, zeroed; NULL when out of memory. */
plii_topology* plii_topology_create(pli_context* context, int face_count, int tetra_count, bool has_materials);
void plii_topology_release(pli_context* context, plii_topology* topology);
/* Each edge of a face is run along as often in one direction as in the other. */
bool plii_topology_is_closed(const plii_topology* topology);

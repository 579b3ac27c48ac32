#ifndef PLII_MESH_IMPL_H
#define PLII_MESH_IMPL_H

#include "body_impl.h"
#include "context.h"
#include "pliant/mesh.h"
#include "vec.h"

struct pli_mesh {
    uint32_t magic;
    pli_context* context;
    int node_count, node_capacity;
    pli_vec3* positions;
    float* inverse_masses;
    int mass_capacity;
    int link_count, link_capacity;
    pli_link* links;
    int face_count, face_capacity;
    pli_face* faces;
    int tetra_count, tetra_capacity;
    pli_tetra* tetras;
    int material_count, material_capacity;
    pli_material* materials;
    /* What bodies share; made by the first body after a change of faces or tetras, NULL before that. */
    plii_topology* topology;
};

#define PLII_MESH_MAGIC 0x706d6573u

/* The shared topology with one more reference; NULL when out of memory. */
plii_topology* plii_mesh_acquire_topology(pli_mesh* mesh);
void plii_topology_release(pli_context* context, plii_topology* topology);

#endif

#pragma once

#include "math/range.h"
#include "mesh/topology.h"
#include "pliant/mesh.h"

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

/* The shared topology with a reference more; in another context a copy of its own. NULL when out of memory. */
plii_topology* plii_mesh_acquire_topology(pli_mesh* mesh, pli_context* context);
/* To be called after every change of faces or tetras. */
void plii_mesh_clear_topology(pli_mesh* mesh);

/* PLI_OK, or the error of a null or wrong handle. */
pli_status plii_check_mesh(const pli_mesh* mesh, const char* function);
/* The same for a call that changes something, which must not come from a callback. */
pli_status plii_check_mesh_change(const pli_mesh* mesh, const char* function);
/* PLI_OK, or the error of an index; messages name `function`. */
pli_status plii_check_mesh_node(const pli_mesh* mesh, int node, const char* function);
pli_status plii_check_mesh_material(const pli_mesh* mesh, int material, const char* function);
pli_status plii_check_material(pli_context* context, const pli_material* material, const char* function);

/* 1 / mass, or 0 for a mass of 0; fails on a mass that is negative, not finite, or too small to be inverted. */
pli_status plii_mesh_invert_mass(const pli_mesh* mesh, float mass, const char* function, float* inverse_mass);

/* For generators: room for so many more elements, then appends that check nothing and cannot fail. */
bool plii_mesh_reserve(pli_mesh* mesh, int nodes, int links, int faces, int tetras);
void plii_mesh_push_node(pli_mesh* mesh, pli_vec3 position, float inverse_mass);
void plii_mesh_push_link(pli_mesh* mesh, int a, int b);
void plii_mesh_push_face(pli_mesh* mesh, int a, int b, int c);
void plii_mesh_push_tetra(pli_mesh* mesh, int a, int b, int c, int d);

/* A new mesh with room for the given elements, for a generator named `function`; nothing is kept on failure. */
pli_status plii_mesh_create_reserved(pli_context* context, int64_t nodes, int64_t links, int64_t faces, int64_t tetras,
                                     const char* function, pli_mesh** mesh);

/* Bullet's permutation of links and faces; cannot fail. */
void plii_mesh_shuffle(pli_mesh* mesh);

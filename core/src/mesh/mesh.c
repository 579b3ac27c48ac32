/* The editable recipe of a body: life, append functions and the topology that bodies of one mesh share. */

#include "mesh/mesh_impl.h"

#include "base/handle.h"
#include "base/key_table.h"

pli_status plii_check_mesh(const pli_mesh* mesh, const char* function) {
    return plii_check_handle(mesh, PLII_HANDLE_MESH, NULL, NULL, function);
}
pli_status plii_check_mesh_change(const pli_mesh* mesh, const char* function) {
    PLII_TRY(plii_check_mesh(mesh, function));
    return plii_check_change(mesh->context, function);
}
pli_status plii_check_mesh_node(const pli_mesh* mesh, int node, const char* function) {
    return plii_check_index(mesh->context, node, mesh->node_count, "node", "mesh", function);
}
pli_status plii_check_mesh_material(const pli_mesh* mesh, int material, const char* function) {
    return plii_check_index(mesh->context, material, mesh->material_count, "material", "mesh", function);
}

pli_status plii_mesh_invert_mass(const pli_mesh* mesh, float mass, const char* function, float* inverse_mass) {
    if (mass != 0.0f) {
        PLII_TRY(plii_check_between(mesh->context, mass, PLI_MIN_MASS, PLI_MAX_MASS, "the mass", function));
    }
    *inverse_mass = mass > 0.0f ? 1.0f / mass : 0.0f;
    return PLI_OK;
}

/* Range of material and nodes of an element, and that no node is named twice. */
static pli_status mesh_check_element(const pli_mesh* mesh, const int* nodes, int count, int material,
                                     const char* function) {
    for (int i = 0; i < count; ++i) {
        PLII_TRY(plii_check_mesh_node(mesh, nodes[i], function));
        for (int j = 0; j < i; ++j) {
            PLII_FAIL_IF(nodes[i] == nodes[j], mesh->context, PLI_ERROR_INVALID_VALUE, function,
                         "node %d is named twice", nodes[i]);
        }
    }
    return plii_check_mesh_material(mesh, material, function);
}

pli_status plii_check_material(pli_context* context, const pli_material* material, const char* function) {
    if (material == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "the material is null"); }
    return plii_check_between(context, material->linear_stiffness, PLI_MIN_STIFFNESS, 1.0f, "the linear stiffness",
                              function);
}

plii_topology* plii_topology_create(pli_context* context, int face_count, int tetra_count, bool has_materials) {
    plii_topology* topology = plii_allocate(context, sizeof *topology);
    if (topology == NULL) { return NULL; }
    topology->reference_count = 1;
    topology->face_count = face_count;
    topology->tetra_count = tetra_count;
    if (!PLII_ALLOCATE(context, &topology->faces, face_count) ||
        !PLII_ALLOCATE(context, &topology->tetras, tetra_count) ||
        !PLII_ALLOCATE(context, &topology->face_materials, has_materials ? face_count : 0)) {
        plii_topology_release(context, topology);
        return NULL;
    }
    return topology;
}

void plii_topology_release(pli_context* context, plii_topology* topology) {
    if (topology == NULL || --topology->reference_count > 0) { return; }
    PLII_RELEASE(context, topology->faces, topology->face_count);
    PLII_RELEASE(context, topology->face_materials, topology->face_count);
    PLII_RELEASE(context, topology->tetras, topology->tetra_count);
    plii_release(context, topology, sizeof *topology);
}

/* Numbers of the edges that cancel where they do, without a list of them. */
bool plii_topology_is_closed(const plii_topology* topology) {
    uint64_t sum = 0;
    for (int i = 0; i < 3 * topology->face_count; ++i) {
        const int *face = topology->faces[i / 3], from = face[i % 3], to = face[(i + 1) % 3];
        uint64_t number = (plii_edge_key(from, to) + 1) * UINT64_C(0x9e3779b97f4a7c15);
        number = (number ^ number >> 32) * UINT64_C(0xbf58476d1ce4e5b9);
        sum += from < to ? number : 0 - number;
    }
    return sum == 0;
}

void plii_mesh_clear_topology(pli_mesh* mesh) {
    plii_topology_release(mesh->context, mesh->topology);
    mesh->topology = NULL;
}

static plii_topology* mesh_make_topology(const pli_mesh* mesh, pli_context* context) {
    bool needs_materials = false;
    for (int i = 0; i < mesh->face_count && !needs_materials; ++i) {
        needs_materials = mesh->faces[i].material != 0;
    }
    plii_topology* topology = plii_topology_create(context, mesh->face_count, mesh->tetra_count, needs_materials);
    if (topology == NULL) { return NULL; }
    for (int i = 0; i < mesh->face_count; ++i) {
        memcpy(topology->faces[i], mesh->faces[i].nodes, sizeof topology->faces[i]);
        if (needs_materials) { topology->face_materials[i] = (uint16_t)mesh->faces[i].material; }
    }
    for (int i = 0; i < mesh->tetra_count; ++i) {
        memcpy(topology->tetras[i], mesh->tetras[i].nodes, sizeof topology->tetras[i]);
    }
    return topology;
}

plii_topology* plii_mesh_acquire_topology(pli_mesh* mesh, pli_context* context) {
    if (context != mesh->context) { return mesh_make_topology(mesh, context); }
    if (mesh->topology == NULL) { mesh->topology = mesh_make_topology(mesh, context); }
    if (mesh->topology != NULL) { ++mesh->topology->reference_count; }
    return mesh->topology;
}

/* ARRAY(field, count, capacity) for each. */
#define MESH_ARRAYS(ARRAY)                                                                                             \
    ARRAY(positions, node_count, node_capacity)                                                                        \
    ARRAY(inverse_masses, node_count, mass_capacity)                                                                   \
    ARRAY(links, link_count, link_capacity)                                                                            \
    ARRAY(faces, face_count, face_capacity)                                                                            \
    ARRAY(tetras, tetra_count, tetra_capacity)                                                                         \
    ARRAY(materials, material_count, material_capacity)

pli_status pli_mesh_create(pli_context* context, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    pli_mesh* made = plii_handle_create(context, PLII_HANDLE_MESH, sizeof *made);
    if (made != NULL) { made->context = context; }
    if (made == NULL || !PLII_RESERVE(context, &made->materials, &made->material_capacity, 1)) {
        pli_mesh_destroy(made);
        return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for a mesh");
    }
    made->materials[0].linear_stiffness = 1.0f;
    made->material_count = 1;
    *mesh = made;
    return PLI_OK;
}

pli_status pli_mesh_clone(const pli_mesh* source, pli_mesh** mesh) {
    PLII_TRY(plii_check_mesh_change(source, __func__));
    PLII_TRY(plii_check_create(source->context, mesh, "mesh", __func__));
    pli_mesh* made = NULL;
    PLII_TRY(plii_mesh_create_reserved(source->context, source->node_count, source->link_count, source->face_count,
                                       source->tetra_count, __func__, &made));
    if (!PLII_RESERVE(made->context, &made->materials, &made->material_capacity, source->material_count)) {
        pli_mesh_destroy(made);
        return PLII_FAIL(source->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d materials",
                         source->material_count);
    }
#define MESH_CLONE(field, count, capacity)                                                                             \
    if (source->count > 0) { memcpy(made->field, source->field, (size_t)source->count * sizeof *made->field); }        \
    made->count = source->count;
    MESH_ARRAYS(MESH_CLONE)
    *mesh = made;
    return PLI_OK;
}

void pli_mesh_destroy(pli_mesh* mesh) {
    if (mesh == NULL || plii_check_mesh_change(mesh, __func__) != PLI_OK) { return; }
    pli_context* context = mesh->context;
    plii_mesh_clear_topology(mesh);
#define MESH_RELEASE(field, count, capacity) PLII_RELEASE(context, mesh->field, mesh->capacity);
    MESH_ARRAYS(MESH_RELEASE)
    plii_handle_release(context, mesh, PLII_HANDLE_MESH, sizeof *mesh);
}

pli_mesh_view pli_mesh_get_view(const pli_mesh* mesh) {
    pli_mesh_view view;
    memset(&view, 0, sizeof view); /* callers may compare views by their bytes */
    if (plii_check_mesh(mesh, __func__) != PLI_OK) { return view; }
#define MESH_VIEW(field, count, capacity)                                                                              \
    view.field = mesh->field;                                                                                          \
    view.count = mesh->count;
    MESH_ARRAYS(MESH_VIEW)
    return view;
}

#define MESH_RESERVE(mesh, field, count, capacity, more)                                                               \
    PLII_RESERVE_MORE((mesh)->context, &(mesh)->field, &(mesh)->capacity, (mesh)->count, more)

bool plii_mesh_reserve(pli_mesh* mesh, int nodes, int links, int faces, int tetras) {
    return MESH_RESERVE(mesh, positions, node_count, node_capacity, nodes) &&
           MESH_RESERVE(mesh, inverse_masses, node_count, mass_capacity, nodes) &&
           MESH_RESERVE(mesh, links, link_count, link_capacity, links) &&
           MESH_RESERVE(mesh, faces, face_count, face_capacity, faces) &&
           MESH_RESERVE(mesh, tetras, tetra_count, tetra_capacity, tetras);
}

void plii_mesh_push_node(pli_mesh* mesh, pli_vec3 position, float inverse_mass) {
    mesh->positions[mesh->node_count] = position;
    mesh->inverse_masses[mesh->node_count++] = inverse_mass;
}
void plii_mesh_push_link(pli_mesh* mesh, int a, int b) {
    mesh->links[mesh->link_count++] = (pli_link){.nodes = {a, b}};
}
void plii_mesh_push_face(pli_mesh* mesh, int a, int b, int c) {
    mesh->faces[mesh->face_count++] = (pli_face){.nodes = {a, b, c}};
}
void plii_mesh_push_tetra(pli_mesh* mesh, int a, int b, int c, int d) {
    mesh->tetras[mesh->tetra_count++] = (pli_tetra){.nodes = {a, b, c, d}};
}

pli_status plii_mesh_create_reserved(pli_context* context, int64_t nodes, int64_t links, int64_t faces, int64_t tetras,
                                     const char* function, pli_mesh** mesh) {
    PLII_FAIL_IF(nodes > INT_MAX || links > INT_MAX || faces > INT_MAX || tetras > INT_MAX, context,
                 PLI_ERROR_INVALID_VALUE, function,
                 "a mesh of %lld nodes, %lld links, %lld faces and %lld tetras is too large", (long long)nodes,
                 (long long)links, (long long)faces, (long long)tetras);
    pli_mesh* made = NULL;
    PLII_TRY(pli_mesh_create(context, &made));
    if (!plii_mesh_reserve(made, (int)nodes, (int)links, (int)faces, (int)tetras)) {
        pli_mesh_destroy(made);
        return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function,
                         "no memory for %lld nodes, %lld links, %lld faces and %lld tetras", (long long)nodes,
                         (long long)links, (long long)faces, (long long)tetras);
    }
    *mesh = made;
    return PLI_OK;
}

static pli_status mesh_out_of_memory(const pli_mesh* mesh, const char* function, const char* what, int count) {
    return plii_fail(mesh->context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for more than %d %s", count, what);
}

static pli_status mesh_append(pli_mesh* mesh, void** elements, int* capacity, int* count, const void* element,
                              size_t size, const char* what, int* index, const char* function) {
    if (*count == INT_MAX || !plii_reserve(mesh->context, elements, capacity, *count + 1, size)) {
        return mesh_out_of_memory(mesh, function, what, *count);
    }
    memcpy((char*)*elements + (size_t)*count * size, element, size);
    if (index != NULL) { *index = *count; }
    *count += 1;
    return PLI_OK;
}
#define MESH_APPEND(mesh, element, value, index)                                                                       \
    mesh_append(mesh, (void**)&(mesh)->element##s, &(mesh)->element##_capacity, &(mesh)->element##_count, &(value),    \
                sizeof(value), #element "s", index, __func__)

pli_status pli_mesh_append_node(pli_mesh* mesh, pli_vec3 position, float mass, int* index) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_vec3_within(mesh->context, position, PLI_MAX_COORDINATE, "the position", __func__));
    float inverse_mass = 0.0f;
    PLII_TRY(plii_mesh_invert_mass(mesh, mass, __func__, &inverse_mass));
    if (!plii_mesh_reserve(mesh, 1, 0, 0, 0)) { return mesh_out_of_memory(mesh, __func__, "nodes", mesh->node_count); }
    if (index != NULL) { *index = mesh->node_count; }
    plii_mesh_push_node(mesh, position, inverse_mass);
    return PLI_OK;
}

pli_status pli_mesh_append_link(pli_mesh* mesh, int node_a, int node_b, int material, int* index) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    const pli_link link = {.nodes = {node_a, node_b}, .material = material};
    PLII_TRY(mesh_check_element(mesh, link.nodes, 2, material, __func__));
    return MESH_APPEND(mesh, link, link, index);
}

pli_status pli_mesh_append_face(pli_mesh* mesh, int a, int b, int c, int material, int* index) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    const pli_face face = {.nodes = {a, b, c}, .material = material};
    PLII_TRY(mesh_check_element(mesh, face.nodes, 3, material, __func__));
    plii_mesh_clear_topology(mesh);
    return MESH_APPEND(mesh, face, face, index);
}

pli_status pli_mesh_append_tetra(pli_mesh* mesh, int a, int b, int c, int d, int material, int* index) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    const pli_tetra tetra = {.nodes = {a, b, c, d}, .material = material};
    PLII_TRY(mesh_check_element(mesh, tetra.nodes, 4, material, __func__));
    plii_mesh_clear_topology(mesh);
    return MESH_APPEND(mesh, tetra, tetra, index);
}

pli_status pli_mesh_append_material(pli_mesh* mesh, const pli_material* material, int* index) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_material(mesh->context, material, __func__));
    PLII_FAIL_IF(mesh->material_count >= PLII_MAX_MATERIALS, mesh->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "a mesh has at most %d materials", PLII_MAX_MATERIALS);
    const pli_material copy = *material; /* may lie in the array that grows */
    return MESH_APPEND(mesh, material, copy, index);
}

pli_status pli_mesh_set_material(pli_mesh* mesh, int index, const pli_material* material) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_mesh_material(mesh, index, __func__));
    PLII_TRY(plii_check_material(mesh->context, material, __func__));
    mesh->materials[index] = *material;
    return PLI_OK;
}

pli_status pli_mesh_set_node_position(pli_mesh* mesh, int node, pli_vec3 position) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_mesh_node(mesh, node, __func__));
    PLII_TRY(plii_check_vec3_within(mesh->context, position, PLI_MAX_COORDINATE, "the position", __func__));
    mesh->positions[node] = position;
    return PLI_OK;
}

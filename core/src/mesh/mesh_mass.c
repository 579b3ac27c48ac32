/* Masses of mesh nodes. Sums and quotients are evaluated in the order of btSoftBody's setTotalMass, setVolumeMass and
   their relatives, so that inverse masses have the same bits; departures are named in mesh.h. */

#include "mesh/mesh_impl.h"

static float mass_sum(int count, const float* inverse_masses) {
    float mass = 0.0f;
    for (int i = 0; i < count; ++i) {
        mass += inverse_masses[i] > 0.0f ? 1.0f / inverse_masses[i] : 0.0f;
    }
    return mass;
}

/* Scales to `mass` in all. Nothing is changed on failure. */
static pli_status mass_normalize(const pli_mesh* mesh, float* inverse_masses, float mass, const char* function) {
    const float inverse_total = 1.0f / mass_sum(mesh->node_count, inverse_masses);
    const float scale = inverse_total * mass;
    for (int i = 0; i < mesh->node_count; ++i) {
        const float scaled = inverse_masses[i] / scale;
        PLII_FAIL_IF(inverse_masses[i] != 0.0f && !plii_is_inverse_mass(scaled), mesh->context, PLI_ERROR_INVALID_VALUE,
                     function, "node %d would get the inverse mass %g for a total of %g, masses go from %g to %g", i,
                     (double)scaled, (double)mass, (double)PLI_MIN_MASS, (double)PLI_MAX_MASS);
    }
    for (int i = 0; i < mesh->node_count; ++i) {
        inverse_masses[i] /= scale;
    }
    return PLI_OK;
}

pli_status pli_mesh_set_node_mass(pli_mesh* mesh, int node, float mass) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_mesh_node(mesh, node, __func__));
    return plii_mesh_invert_mass(mesh, mass, __func__, &mesh->inverse_masses[node]);
}

PLII_DEFINE_GET(float, pli_mesh_total_mass, mesh, mass_sum(mesh->node_count, mesh->inverse_masses), 0.0f)

pli_status pli_mesh_set_total_mass(pli_mesh* mesh, float mass) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_TRY(plii_check_between(mesh->context, mass, PLII_ABOVE_0, FLT_MAX, "the mass", __func__));
    PLII_FAIL_IF(!(mass_sum(mesh->node_count, mesh->inverse_masses) > 0.0f), mesh->context, PLI_ERROR_INVALID_MESH,
                 __func__, "none of the %d nodes can have a mass, all are pinned", mesh->node_count);
    return mass_normalize(mesh, mesh->inverse_masses, mass, __func__);
}

/* Fills `sums` per node and how many elements were added, in the order of the elements. */
static void mass_gather_faces(const pli_mesh* mesh, float* sums, float* ranks) {
    for (PLII_EACH(const pli_face, face, mesh->faces, mesh->face_count)) {
        const int* n = face->nodes;
        const pli_vec3 a = pli_vec3_sub(mesh->positions[n[1]], mesh->positions[n[0]]);
        const pli_vec3 b = pli_vec3_sub(mesh->positions[n[2]], mesh->positions[n[0]]);
        const float doubled_area = pli_vec3_length(pli_vec3_cross(a, b));
        for (int j = 0; j < 3; ++j) {
            sums[n[j]] += doubled_area;
        }
    }
    for (int i = 0; i < mesh->node_count; ++i) {
        ranks[i] = 1.0f;
    }
}

/* Six times the volume. */
static float mass_tetra_measure(const pli_mesh* mesh, const pli_tetra* tetra) {
    const pli_vec3 origin = mesh->positions[tetra->nodes[0]];
    const pli_vec3 a = pli_vec3_sub(mesh->positions[tetra->nodes[1]], origin);
    const pli_vec3 b = pli_vec3_sub(mesh->positions[tetra->nodes[2]], origin);
    const pli_vec3 c = pli_vec3_sub(mesh->positions[tetra->nodes[3]], origin);
    return fabsf(pli_vec3_dot(a, pli_vec3_cross(b, c)));
}

static void mass_gather_tetras(const pli_mesh* mesh, float* sums, float* ranks) {
    for (int i = 0; i < mesh->tetra_count; ++i) {
        const float measure = mass_tetra_measure(mesh, &mesh->tetras[i]);
        for (int j = 0; j < 4; ++j) {
            sums[mesh->tetras[i].nodes[j]] += measure;
            ranks[mesh->tetras[i].nodes[j]] += 1.0f;
        }
    }
}

/* Masses of nodes that are not pinned, by weights, which are sums here, over ranks; of a zero sum, mass / count. */
static pli_status mass_share_out(pli_mesh* mesh, float mass, float* weights, const float* ranks, const char* what,
                                 const char* function) {
    int free_count = 0, measured_count = 0;
    for (int i = 0; i < mesh->node_count; ++i) {
        const bool is_free = mesh->inverse_masses[i] > 0.0f;
        const float weight = ranks[i] / weights[i];
        const bool is_measured = is_free && weights[i] > 0.0f && plii_is_finite(weight) && weight > 0.0f;
        free_count += is_free;
        measured_count += is_measured;
        weights[i] = is_measured ? weight : 0.0f;
    }
    PLII_FAIL_IF(measured_count == 0, mesh->context, PLI_ERROR_INVALID_MESH, function,
                 "no node that is not pinned has a %s", what);
    const float rest = (float)free_count / mass;
    PLII_FAIL_IF(measured_count < free_count && !plii_is_inverse_mass(rest), mesh->context, PLI_ERROR_INVALID_VALUE,
                 function,
                 "nodes without a %s would get the inverse mass %g for a total of %g, masses go from %g to %g", what,
                 (double)rest, (double)mass, (double)PLI_MIN_MASS, (double)PLI_MAX_MASS);
    float shared = mass;
    if (measured_count < free_count) { shared = mass * ((float)measured_count / (float)free_count); }
    PLII_TRY(mass_normalize(mesh, weights, shared, function));
    for (int i = 0; i < mesh->node_count; ++i) {
        if (mesh->inverse_masses[i] > 0.0f) { mesh->inverse_masses[i] = weights[i] > 0.0f ? weights[i] : rest; }
    }
    return PLI_OK;
}

static pli_status mass_distribute(pli_mesh* mesh, float mass, bool by_tetras, const char* function) {
    plii_scratch scratch = {.context = mesh->context};
    float* weights = PLII_TAKE(&scratch, float, mesh->node_count);
    float* ranks = PLII_TAKE(&scratch, float, mesh->node_count);
    pli_status status = PLI_ERROR_OUT_OF_MEMORY;
    if (scratch.is_short) {
        plii_fail(mesh->context, status, function, "no memory for the weights of %d nodes", mesh->node_count);
    } else {
        (by_tetras ? mass_gather_tetras : mass_gather_faces)(mesh, weights, ranks);
        const char* what = by_tetras ? "tetrahedron with a volume" : "face with an area";
        status = mass_share_out(mesh, mass, weights, ranks, what, function);
    }
    plii_scratch_free(&scratch);
    return status;
}

static pli_status mass_set_total(pli_mesh* mesh, float mass, bool by_tetras, const char* function) {
    PLII_TRY(plii_check_mesh_change(mesh, function));
    PLII_TRY(plii_check_between(mesh->context, mass, PLII_ABOVE_0, FLT_MAX, "the mass", function));
    return mass_distribute(mesh, mass, by_tetras, function);
}

pli_status pli_mesh_set_total_mass_from_faces(pli_mesh* mesh, float mass) {
    return mass_set_total(mesh, mass, false, __func__);
}
pli_status pli_mesh_set_total_mass_from_tetras(pli_mesh* mesh, float mass) {
    return mass_set_total(mesh, mass, true, __func__);
}

static pli_status mass_set_density(pli_mesh* mesh, float density, bool by_tetras, const char* function) {
    PLII_TRY(plii_check_mesh_change(mesh, function));
    PLII_TRY(plii_check_between(mesh->context, density, PLII_ABOVE_0, FLT_MAX, "the density", function));
    float measure = by_tetras ? 0.0f : fabsf(pli_mesh_volume(mesh));
    for (PLII_EACH(const pli_tetra, tetra, mesh->tetras, by_tetras ? mesh->tetra_count : 0)) {
        measure += mass_tetra_measure(mesh, tetra);
    }
    const float parts = by_tetras ? 6.0f : 1.0f, mass = measure * density / parts;
    if (mass > 0.0f && plii_is_finite(mass)) { return mass_distribute(mesh, mass, by_tetras, function); }
    return plii_fail(mesh->context, PLI_ERROR_INVALID_MESH, function, "the %s %g m^3 of %g kg/m^3",
                     by_tetras ? "tetrahedra hold" : "faces enclose", (double)(measure / parts), (double)density);
}

pli_status pli_mesh_set_density_from_faces(pli_mesh* mesh, float density) {
    return mass_set_density(mesh, density, false, __func__);
}
pli_status pli_mesh_set_density_from_tetras(pli_mesh* mesh, float density) {
    return mass_set_density(mesh, density, true, __func__);
}

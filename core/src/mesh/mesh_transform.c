/* Motion, volume and bounds of a mesh, in the operation order of btSoftBody's transform, scale and getVolume. */

#include "math/bounds.h"
#include "mesh/mesh_impl.h"

/* Moves all nodes or, if one would be too far out, none. */
static pli_status transform_apply(pli_mesh* mesh, pli_transform transform, const char* function) {
    PLII_TRY(plii_check_mesh_change(mesh, function));
    PLII_FAIL_IF(!plii_transform_is_finite(transform), mesh->context, PLI_ERROR_NOT_FINITE, function,
                 "the transform is not finite");
    for (int i = 0; i < mesh->node_count; ++i) {
        const pli_vec3 moved = pli_transform_point(transform, mesh->positions[i]);
        PLII_FAIL_IF(!plii_vec3_is_finite(moved), mesh->context, PLI_ERROR_NOT_FINITE, function,
                     "node %d would leave the range of float", i);
        PLII_FAIL_IF(!plii_is_point(moved), mesh->context, PLI_ERROR_INVALID_VALUE, function,
                     "node %d would be at (%g, %g, %g), coordinates go to %g", i, (double)moved.x, (double)moved.y,
                     (double)moved.z, (double)PLI_MAX_COORDINATE);
    }
    for (int i = 0; i < mesh->node_count; ++i) {
        mesh->positions[i] = pli_transform_point(transform, mesh->positions[i]);
    }
    return PLI_OK;
}

pli_status pli_mesh_transform(pli_mesh* mesh, pli_transform transform) {
    return transform_apply(mesh, transform, __func__);
}
pli_status pli_mesh_translate(pli_mesh* mesh, pli_vec3 offset) {
    pli_transform transform = pli_transform_identity();
    transform.origin = offset;
    return transform_apply(mesh, transform, __func__);
}
pli_status pli_mesh_rotate(pli_mesh* mesh, pli_quat rotation) {
    return transform_apply(mesh, pli_transform_make(rotation, pli_vec3_make(0, 0, 0)), __func__);
}

pli_status pli_mesh_scale(pli_mesh* mesh, pli_vec3 factors) {
    PLII_TRY(plii_check_mesh_change(mesh, __func__));
    PLII_FAIL_IF(!plii_vec3_is_finite(factors), mesh->context, PLI_ERROR_NOT_FINITE, __func__,
                 "the factors are (%g, %g, %g)", (double)factors.x, (double)factors.y, (double)factors.z);
    const pli_transform scale = {plii_mat3_diagonal(factors.x, factors.y, factors.z), {0, 0, 0}};
    return transform_apply(mesh, scale, __func__);
}

float pli_mesh_volume(const pli_mesh* mesh) {
    if (plii_check_mesh(mesh, __func__) != PLI_OK || mesh->node_count == 0) { return 0.0f; }
    const pli_vec3 origin = mesh->positions[0];
    float volume = 0.0f;
    for (int i = 0; i < mesh->face_count; ++i) {
        const int* n = mesh->faces[i].nodes;
        const pli_vec3 a = pli_vec3_sub(mesh->positions[n[0]], origin);
        const pli_vec3 b = pli_vec3_sub(mesh->positions[n[1]], origin);
        const pli_vec3 c = pli_vec3_sub(mesh->positions[n[2]], origin);
        volume += pli_vec3_dot(a, pli_vec3_cross(b, c));
    }
    return volume / 6.0f;
}

PLII_DEFINE_GET(pli_bounds, pli_mesh_bounds, mesh, plii_bounds_of_points(mesh->node_count, mesh->positions),
                (pli_bounds){0})

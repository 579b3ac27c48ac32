/* Masses, rest shape and inertia of clusters. Bullet: initializeClusters, in its order of operations. */

#include "cluster/cluster_impl.h"
#include "math/dvec3.h"
#include "math/rotation_fit.h"

/* Mass of a pinned node: in reference mode an absolute one, else this many times all other masses of the cluster. Where
   there are none it is that of the heaviest that there is, since whatever hangs on the cluster shall not move it. */
#define CLUSTER_BULLET_PINNED_MASS 1e18f
#define CLUSTER_PINNED_MASS_RATIO 1e6

static void cluster_update_masses(const pli_body* body, plii_cluster* cluster) {
    plii_cluster_member* members = &body->clusters->members[cluster->first_member];
    double free_mass = 0.0;
    cluster->contains_pinned_node = false;
    for (int i = 0; i < cluster->member_count; ++i) {
        const float inverse_mass = body->positions[members[i].node].w;
        free_mass += inverse_mass > 0.0f ? 1.0 / (double)inverse_mass : 0.0;
        cluster->contains_pinned_node = cluster->contains_pinned_node || !(inverse_mass > 0.0f);
    }
    float pinned_mass = CLUSTER_BULLET_PINNED_MASS;
    if (!body->clusters->def.reference_mode) {
        pinned_mass = free_mass > 0.0 ? (float)(CLUSTER_PINNED_MASS_RATIO * fmax(free_mass, 1e-6)) : PLI_MAX_MASS;
    }
    double total = 0.0;
    for (int i = 0; i < cluster->member_count; ++i) {
        const float inverse_mass = body->positions[members[i].node].w;
        members[i].rest.w = inverse_mass > 0.0f ? 1.0f / inverse_mass : pinned_mass;
        total += (double)members[i].rest.w;
        if (body->clusters->def.reference_mode) { total = (double)(float)total; }
    }
    cluster->inverse_mass = (float)(1.0 / total);
}

/* Inverse of an inertia that may be singular: nodes in a line, or one node, do not turn about the directions in which
   they have no inertia, or less than `smallest` (Bullet divides by zero there). */
static pli_mat3 cluster_pseudo_inverse(pli_mat3 inertia, double smallest) {
    double a[4][4] = {{0}}, axes[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (int i = 0; i < 3; ++i) {
        a[i][0] = (double)inertia.rows[i].x;
        a[i][1] = (double)inertia.rows[i].y;
        a[i][2] = (double)inertia.rows[i].z;
    }
    plii_diagonalize(a, axes);
    const double largest = fmax(a[0][0], fmax(a[1][1], a[2][2]));
    double inverse[3][3] = {{0}};
    for (int k = 0; k < 3; ++k) {
        if (!(a[k][k] > 1e-6 * largest) || !(a[k][k] > smallest)) { continue; }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                inverse[i][j] += axes[k][i] * axes[k][j] / a[k][k];
            }
        }
    }
    pli_mat3 result;
    for (int i = 0; i < 3; ++i) {
        result.rows[i] = pli_vec3_make((float)inverse[i][0], (float)inverse[i][1], (float)inverse[i][2]);
    }
    return plii_mat3_is_finite(result) ? result : plii_mat3_diagonal(0, 0, 0);
}

/* The inertia that the rounding of coordinates alone would give, and some more. */
static double cluster_smallest_inertia(const pli_body* body, const plii_cluster* cluster) {
    const pli_vec3 min = body->bounds.min, max = body->bounds.max;
    const float x = plii_max(fabsf(min.x), fabsf(max.x)), y = plii_max(fabsf(min.y), fabsf(max.y));
    const float size = plii_max(plii_max(x, y), fmaxf(fabsf(min.z), fabsf(max.z)));
    const double blur = 16.0 * (double)PLII_EPSILON * (double)size;
    return blur * blur / (double)cluster->inverse_mass + 1e-30;
}

/* From masses and rest shape. */
static void cluster_update_rest_inertia(const pli_body* body, plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    pli_mat3 inertia = plii_mat3_diagonal(0, 0, 0);
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 k = plii_xyz(members[i].rest);
        const float mass = members[i].rest.w;
        inertia.rows[0].x += mass * (k.y * k.y + k.z * k.z);
        inertia.rows[1].y += mass * (k.x * k.x + k.z * k.z);
        inertia.rows[2].z += mass * (k.x * k.x + k.y * k.y);
        inertia.rows[0].y -= mass * k.x * k.y;
        inertia.rows[0].z -= mass * k.x * k.z;
        inertia.rows[1].z -= mass * k.y * k.z;
    }
    inertia.rows[1].x = inertia.rows[0].y;
    inertia.rows[2].x = inertia.rows[0].z;
    inertia.rows[2].y = inertia.rows[1].z;
    const pli_mat3 inverse = plii_mat3_inverse(inertia);
    const bool is_finite = plii_mat3_is_finite(inverse);
    cluster->has_no_inverse = body->clusters->def.reference_mode && !is_finite;
    cluster->inverse_inertia_local = body->clusters->def.reference_mode && is_finite
                                         ? inverse
                                         : cluster_pseudo_inverse(inertia, cluster_smallest_inertia(body, cluster));
    const pli_mat3* turns = &cluster->inverse_inertia_local;
    cluster->is_point = turns->rows[0].x + turns->rows[1].y + turns->rows[2].z == 0.0f;
}

/* Puts the rest shape about its centre of mass, in double, and returns where that was: by what it is off matching moves
   the body in each step, for ever. */
static pli_vec3 cluster_centre_rest_shape(const pli_body* body, const plii_cluster* cluster) {
    plii_cluster_member* members = &body->clusters->members[cluster->first_member];
    plii_dvec3 moment = {0.0, 0.0, 0.0};
    double total = 0.0;
    for (int i = 0; i < cluster->member_count; ++i) {
        const double mass = (double)members[i].rest.w;
        moment = plii_dvec3_add_scaled(moment, plii_dvec3_from(plii_xyz(members[i].rest)), mass);
        total += mass;
    }
    const pli_vec3 centre = plii_dvec3_to_float(plii_dvec3_scale(moment, 1.0 / total));
    for (int i = 0; i < cluster->member_count; ++i) {
        plii_set_xyz(&members[i].rest, pli_vec3_sub(plii_xyz(members[i].rest), centre));
    }
    return centre;
}

void plii_cluster_set_rest_shape(const pli_body* body, plii_cluster* cluster) {
    cluster_update_masses(body, cluster);
    plii_cluster_member* members = &body->clusters->members[cluster->first_member];
    pli_vec3 centre = plii_cluster_centre(body, cluster);
    for (int i = 0; i < cluster->member_count; ++i) {
        plii_set_xyz(&members[i].rest, pli_vec3_sub(plii_xyz(body->positions[members[i].node]), centre));
    }
    if (!body->clusters->def.reference_mode) {
        centre = pli_vec3_add(centre, cluster_centre_rest_shape(body, cluster));
    }
    cluster_update_rest_inertia(body, cluster);
    cluster->rest_centre = pli_vec3_make(0, 0, 0);
    cluster->frame = (pli_transform){pli_mat3_identity(), centre};
    cluster->warm_rotation = pli_quat_identity();
    cluster->linear_velocity = cluster->angular_velocity = (pli_vec4){0};
    cluster->has_bounds = false;
}

void plii_cluster_update_masses(const pli_body* body, plii_cluster* cluster) {
    cluster_update_masses(body, cluster);
    const pli_vec3 shift = cluster_centre_rest_shape(body, cluster);
    cluster_update_rest_inertia(body, cluster);
    cluster->rest_centre = pli_vec3_add(cluster->rest_centre, shift);
    cluster->has_bounds = false;
}

#ifndef PLIANT_FORCES_H
#define PLIANT_FORCES_H

/// Forces on soft bodies: aerodynamics, pressure, conservation of volume. They act on the normals of the start of the
/// step and on node areas taken when the feature is enabled.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// In Bullet's order. VERTEX models act on nodes, FACE models on faces.
typedef enum pli_aero_model {
    PLI_AERO_VERTEX_POINT = 0,
    PLI_AERO_VERTEX_TWO_SIDED = 1,
    PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG = 2,
    PLI_AERO_VERTEX_ONE_SIDED = 3,
    PLI_AERO_FACE_TWO_SIDED = 4,
    PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG = 5,
    PLI_AERO_FACE_ONE_SIDED = 6
} pli_aero_model;

typedef struct pli_aero_def {
    pli_aero_model model;
    float lift;    ///< 0 to PLI_MAX_FACTOR, default 0. Bullet name: kLF
    float drag;    ///< 0 to PLI_MAX_FACTOR, default 0. Bullet name: kDG
    pli_vec3 wind; ///< m/s, up to PLI_MAX_SPEED
    uint32_t cookie;
} pli_aero_def;

PLI_API pli_aero_def pli_aero_def_default(void);
/// Enable, or change when enabled.
PLI_API pli_status pli_body_enable_aero(pli_body* body, const pli_aero_def* def);
PLI_API pli_status pli_body_set_wind(pli_body* body, pli_vec3 wind);
PLI_API void pli_body_disable_aero(pli_body* body);

/// Gas inside a closed surface: each node gets normal * area * coefficient / |volume|. No force while the volume is
/// zero (Bullet divides by it).
/// @param coefficient N m, of either sign, up to PLI_MAX_COEFFICIENT. Bullet name: kPR
PLI_API pli_status pli_body_enable_pressure(pli_body* body, float coefficient);
PLI_API void pli_body_disable_pressure(pli_body* body);

/// A force towards the rest volume: each node gets normal * area * (rest volume - volume) * coefficient.
/// The rest volume is the present one.
/// @param coefficient N/m^5, 0 to PLI_MAX_COEFFICIENT. Bullet name: kVC with setPose(true, false)
PLI_API pli_status pli_body_enable_volume_conservation(pli_body* body, float coefficient);
PLI_API void pli_body_disable_volume_conservation(pli_body* body);

#ifdef __cplusplus
}
#endif
#endif

#ifndef DEMOS_FINITE_H
#define DEMOS_FINITE_H

#include <pliant/pliant.h>

#include <cmath>

namespace demos {

inline bool is_finite(pli_vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool is_finite(const pli_transform& t) {
    return is_finite(t.origin) && is_finite(t.rotation.rows[0]) && is_finite(t.rotation.rows[1]) &&
           is_finite(t.rotation.rows[2]);
}

} // namespace demos
#endif

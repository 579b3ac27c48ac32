#ifndef PLIANT_BULLET_CONVERT_H
#define PLIANT_BULLET_CONVERT_H

// Bullet's types, in single or double precision, to and from the core's. Exact in single precision.

#include <LinearMath/btTransform.h>
#include <pliant/math.h>

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace pliant {

inline float to_float(btScalar value) {
    return static_cast<float>(value);
}

inline pli_vec3 to_pli(const btVector3& v) {
    return pli_vec3_make(to_float(v.x()), to_float(v.y()), to_float(v.z()));
}

inline btVector3 to_bullet(pli_vec3 v) {
    return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
}

inline pli_mat3 to_pli(const btMatrix3x3& m) {
    return {{to_pli(m.getRow(0)), to_pli(m.getRow(1)), to_pli(m.getRow(2))}};
}

inline pli_transform to_pli(const btTransform& t) {
    return {to_pli(t.getBasis()), to_pli(t.getOrigin())};
}

inline btTransform to_bullet(const pli_transform& t) {
    const pli_vec3* rows = t.rotation.rows;
    const btMatrix3x3 basis(rows[0].x, rows[0].y, rows[0].z, rows[1].x, rows[1].y, rows[1].z, rows[2].x, rows[2].y,
                            rows[2].z);
    return btTransform(basis, to_bullet(t.origin));
}

/// Word by word: of large types a call of memcmp would cost more than what asks.
template <class T> bool same_bits(const T& a, const T& b) {
    using Word = std::conditional_t<sizeof(T) % sizeof(std::uint64_t) == 0, std::uint64_t, std::uint32_t>;
    static_assert(sizeof(T) % sizeof(Word) == 0);
    Word difference = 0;
#pragma GCC unroll 8
    for (std::size_t i = 0; i < sizeof(T); i += sizeof(Word)) {
        Word word_a, word_b;
        std::memcpy(&word_a, reinterpret_cast<const char*>(&a) + i, sizeof word_a);
        std::memcpy(&word_b, reinterpret_cast<const char*>(&b) + i, sizeof word_b);
        difference |= word_a ^ word_b;
    }
    return difference == 0;
}

/// What `value` becomes when the core changed `before` into `after`: `after` itself in single precision, otherwise
/// `value` plus the change, which keeps the digits that the core does not see.
inline btVector3 with_change(const btVector3& value, pli_vec3 before, pli_vec3 after) {
    if constexpr (sizeof(btScalar) == sizeof(float)) { return to_bullet(after); }
    return value + (to_bullet(after) - to_bullet(before));
}

} // namespace pliant

#endif

/* Values out of bytes. */

#include "byte_source.h"

#include <float.h>
#include <limits.h>
#include <string.h>

bool bytes_are_done(const byte_source* bytes) {
    return bytes->at >= bytes->end;
}

int bytes_next(byte_source* bytes) {
    return bytes->at < bytes->end ? *bytes->at++ : 0;
}

int bytes_below(byte_source* bytes, int count) {
    return bytes_next(bytes) % count;
}

bool bytes_flag(byte_source* bytes) {
    return bytes_next(bytes) % 2 == 1;
}

bool bytes_seldom(byte_source* bytes, int share) {
    return bytes_next(bytes) >= 256 - share;
}

int bytes_small(byte_source* bytes, int least, int most) {
    const int byte = bytes_next(bytes);
    if (byte == 255) { return least - 1; }
    if (byte == 254) { return 0; }
    return least + byte % (most - least + 1);
}

int bytes_count(byte_source* bytes, int least, int most) {
    static const int borders[] = {INT_MAX, INT_MIN, -1, 0, INT_MAX - 3, 1};
    const int byte = bytes_next(bytes);
    if (byte >= 250) { return borders[byte - 250]; }
    return least + byte % (most - least + 1);
}

int bytes_index(byte_source* bytes, int count) {
    const int low = bytes_next(bytes), index = count > 256 ? low + 256 * bytes_next(bytes) : low;
    if (low >= 254) { return low == 255 ? count : -1; }
    return count > 0 ? index % count : 0;
}

float bytes_float(byte_source* bytes, float least, float most) {
    static const float borders[] = {0.0f,       -0.0f,  1.0f,   -1.0f,  FLT_MIN, 1e-45f, FLT_MAX,   -FLT_MAX, HUGE_VALF,
                                    -HUGE_VALF, NAN,    1e-6f,  1e-3f,  1e3f,    -1e3f,  1e5f,      1e6f,     -1e6f,
                                    1e8f,       1e9f,   1e12f,  1e15f,  1e18f,   -1e18f, 1e20f,     -1e20f,   1e25f,
                                    1e30f,      -1e30f, 1e-10f, 1e-20f, 1e-30f,  3e38f,  0.999999f, 1.000001f};
    const int byte = bytes_next(bytes);
    if (byte < 244) { return least + (most - least) * ((float)byte / 243.0f); }
    float value = 0.0f;
    if (byte < 254) {
        value = borders[bytes_below(bytes, (int)(sizeof borders / sizeof *borders))];
    } else {
        uint32_t bits = 0;
        for (int i = 0; i < 4; ++i) {
            bits = bits << 8 | (uint32_t)bytes_next(bytes);
        }
        memcpy(&value, &bits, sizeof value);
    }
    return bytes->is_tame ? most : value;
}

pli_vec3 bytes_vec3(byte_source* bytes, float least, float most) {
    const float x = bytes_float(bytes, least, most);
    const float y = bytes_float(bytes, least, most);
    const float z = bytes_float(bytes, least, most);
    return pli_vec3_make(x, y, z);
}

pli_mat3 bytes_rotation(byte_source* bytes) {
    const int kind = bytes_next(bytes);
    pli_mat3 matrix = pli_mat3_identity();
    if (kind < 128) { return matrix; }
    const pli_vec3 angles = bytes_vec3(bytes, -3.2f, 3.2f);
    matrix = pli_mat3_from_euler_zyx(angles.x, angles.y, angles.z);
    if (kind >= 250 && !bytes->is_tame) { matrix.rows[kind % 3] = angles; }
    return matrix;
}

pli_transform bytes_transform(byte_source* bytes, float reach) {
    pli_transform transform;
    transform.rotation = bytes_rotation(bytes);
    transform.origin = bytes_vec3(bytes, -reach, reach);
    return transform;
}

#include "decoded.h"

#include "check.h"

#include <stb_image.h>

#include <cstddef>
#include <vector>

void PixelDeleter::operator()(unsigned char* pixels) const {
    stbi_image_free(pixels);
}

Decoded::Decoded(const std::string& file) {
    int channels = 0;
    pixels.reset(stbi_load(file.c_str(), &width, &height, &channels, 3));
    if (pixels == nullptr) { fail_msg("%s is no picture", file.c_str()); }
    assert_int_equal(channels, 3);
}

std::array<int, 3> Decoded::at(int x, int y) const {
    const unsigned char* pixel = pixels.get() + 3 * (static_cast<std::ptrdiff_t>(y) * width + x);
    return {pixel[0], pixel[1], pixel[2]};
}

double Decoded::warm_share(int from, int to) const {
    int count = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = from; x < to; ++x) {
            count += at(x, y)[0] > at(x, y)[2] + 60 ? 1 : 0;
        }
    }
    return static_cast<double>(count) / (static_cast<double>(to - from) * height);
}

size_t Decoded::color_count() const {
    std::vector<bool> is_there(1 << 24);
    size_t count = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::array<int, 3> color = at(x, y);
            const auto index = static_cast<size_t>((color[0] << 16) + (color[1] << 8) + color[2]);
            count += is_there[index] ? 0U : 1U;
            is_there[index] = true;
        }
    }
    return count;
}

#include "image.h"

#include <stb_image_write.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace render {

Image::Image(int width_, int height_)
    : width(width_), height(height_), pixels(3 * static_cast<size_t>(width_) * static_cast<size_t>(height_)) {}

void Image::paste(const Image& part, int x, int y) {
    for (int row = 0; row < part.height; ++row) {
        const auto from = part.pixels.begin() + std::ptrdiff_t{3} * row * part.width;
        const auto to = pixels.begin() + std::ptrdiff_t{3} * ((row + y) * width + x);
        std::copy(from, from + std::ptrdiff_t{3} * part.width, to);
    }
}

static void image_append(void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
}

std::string Image::to_png() const {
    std::string bytes;
    if (stbi_write_png_to_func(image_append, &bytes, width, height, 3, pixels.data(), 3 * width) == 0) {
        throw std::runtime_error("the picture cannot be encoded as PNG");
    }
    return bytes;
}

} // namespace render

#include "text.h"

#include <stb_easy_font.h>

namespace render {

// What stb_easy_font_print writes per corner.
struct FontVertex {
    float x, y, z;
    unsigned char color[4];
};

// The font's functions take text that they could write to.
static std::vector<char> printable(const std::string& text) {
    std::vector<char> copy;
    for (const char c : text) {
        copy.push_back(c >= ' ' && c <= '~' ? c : '?');
    }
    copy.push_back('\0');
    return copy;
}

std::vector<float> text_triangles(const std::string& text, float x, float y, float scale) {
    std::vector<char> copy = printable(text);
    std::vector<FontVertex> vertices(4 * 80 * copy.size());
    const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, vertices.data(),
                                          static_cast<int>(vertices.size() * sizeof(FontVertex)));
    std::vector<float> corners;
    for (int quad = 0; quad < quads; ++quad) {
        for (const int corner : {0, 1, 2, 0, 2, 3}) {
            const FontVertex& vertex = vertices[static_cast<size_t>(4 * quad + corner)];
            corners.push_back(x + scale * vertex.x);
            corners.push_back(y + scale * vertex.y);
        }
    }
    return corners;
}

float text_width(const std::string& text, float scale) {
    return scale * static_cast<float>(stb_easy_font_width(printable(text).data()));
}

float text_height(float scale) {
    return 8.0f * scale;
}

} // namespace render

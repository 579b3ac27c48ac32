#ifndef DEMOS_RENDER_IMAGE_H
#define DEMOS_RENDER_IMAGE_H

// Pixels, and their form as a PNG file.

#include <string>
#include <vector>

namespace render {

struct Image {
    int width = 0, height = 0;
    std::vector<unsigned char> pixels; // red, green, blue; rows from top to bottom

    Image(int width_, int height_);
    // Copies `part` so that its top left pixel comes to (x, y); it must fit.
    void paste(const Image& part, int x, int y);
    std::string to_png() const;
};

} // namespace render
#endif

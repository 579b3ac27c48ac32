#ifndef DEMOS_RENDER_TEXT_H
#define DEMOS_RENDER_TEXT_H

// Words in a picture.

#include <string>
#include <vector>

namespace render {

// Corners x, y of triangles, in pixels from the top left corner of the picture, y down.
std::vector<float> text_triangles(const std::string& text, float x, float y, float scale);
float text_width(const std::string& text, float scale);
// Of one line of capitals.
float text_height(float scale);

} // namespace render
#endif

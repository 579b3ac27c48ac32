#ifndef DEMOS_RENDER_PROGRAM_H
#define DEMOS_RENDER_PROGRAM_H

// A linked pair of shaders.

#include "matrix.h"

#include <epoxy/gl.h>

namespace render {

class Program {
public:
    // Throws demos::Error with the compiler's first line when the sources do not compile.
    Program(const char* vertex_source, const char* fragment_source);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void use() const;
    void set(const char* name, float value) const;
    void set(const char* name, float x, float y) const;
    void set(const char* name, pli_vec3 value) const;
    void set(const char* name, const Matrix4& value) const;
    void set_unit(const char* name, int texture_unit) const;

private:
    GLuint id_;
};

} // namespace render
#endif

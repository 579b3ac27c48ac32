#include "program.h"

#include "description/error.h"

#include <string>

namespace render {

static std::string first_line(const char* text) {
    const std::string all(text);
    return all.substr(0, all.find('\n'));
}

static GLuint compile_shader(GLenum kind, const char* source) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE) {
        char log[1024] = "";
        glGetShaderInfoLog(shader, sizeof log, nullptr, log);
        glDeleteShader(shader);
        throw demos::Error("a shader does not compile: " + first_line(log));
    }
    return shader;
}

Program::Program(const char* vertex_source, const char* fragment_source) : id_(glCreateProgram()) {
    const GLuint vertex = compile_shader(GL_VERTEX_SHADER, vertex_source);
    const GLuint fragment = compile_shader(GL_FRAGMENT_SHADER, fragment_source);
    glAttachShader(id_, vertex);
    glAttachShader(id_, fragment);
    glLinkProgram(id_);
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    GLint linked = GL_FALSE;
    glGetProgramiv(id_, GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) {
        char log[1024] = "";
        glGetProgramInfoLog(id_, sizeof log, nullptr, log);
        throw demos::Error("shaders do not link: " + first_line(log));
    }
}

Program::~Program() {
    glDeleteProgram(id_);
}

void Program::use() const {
    glUseProgram(id_);
}

void Program::set(const char* name, float value) const {
    glUniform1f(glGetUniformLocation(id_, name), value);
}

void Program::set(const char* name, float x, float y) const {
    glUniform2f(glGetUniformLocation(id_, name), x, y);
}

void Program::set(const char* name, pli_vec3 value) const {
    glUniform3f(glGetUniformLocation(id_, name), value.x, value.y, value.z);
}

void Program::set(const char* name, const Matrix4& value) const {
    glUniformMatrix4fv(glGetUniformLocation(id_, name), 1, GL_FALSE, value.data());
}

void Program::set_unit(const char* name, int texture_unit) const {
    glUniform1i(glGetUniformLocation(id_, name), texture_unit);
}

} // namespace render

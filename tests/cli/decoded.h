#ifndef TESTS_CLI_DECODED_H
#define TESTS_CLI_DECODED_H

// A picture that the program has written, read back.

#include <array>
#include <memory>
#include <string>

struct PixelDeleter {
    void operator()(unsigned char* pixels) const;
};

struct Decoded {
    int width = 0, height = 0;
    std::unique_ptr<unsigned char, PixelDeleter> pixels;

    explicit Decoded(const std::string& file);
    std::array<int, 3> at(int x, int y) const;
    // Share of the pixels from column `from` up to `to` that are much redder than blue, as soft bodies are and nothing
    // else is.
    double warm_share(int from, int to) const;
    size_t color_count() const;
};

#endif

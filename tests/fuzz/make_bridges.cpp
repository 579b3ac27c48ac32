// Writes files of bridges into a folder: where the fuzzer of their reader begins.

#include "bridge_scene.hpp"

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
    if (argc != 2) { return 2; }
    pli_context* context = nullptr;
    fuzz::require(pli_context_create(nullptr, &context) == PLI_OK);
    {
        fuzz::Scene scene(context, false);
        for (const int frames : {0, 20, 200}) {
            scene.stock.step(frames);
            const std::vector<unsigned char> bytes = scene.file();
            const std::string path = std::string(argv[1]) + "/bridge_" + std::to_string(frames);
            std::FILE* file = std::fopen(path.c_str(), "wb");
            fuzz::require(file != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size());
            std::fclose(file);
        }
    }
    return pli_context_destroy(context) == PLI_OK ? 0 : 1;
}

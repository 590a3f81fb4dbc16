// Simplifies a file and writes the result in the format of its name: file IN OUT RATIO
#include <cstdio>
#include <string>

#include "neural_mesh.hpp"

int main(int argc, char **argv) {
    if (argc != 4) return std::fprintf(stderr, "file IN OUT RATIO\n"), 2;
    const std::string out = argv[2];
    try {
        neural_mesh::Job job;
        job.set("ratio", argv[3]).set("format", out.substr(out.rfind('.') + 1)).read_file(argv[1]);
        job.listen([](float done, const char *stage) {
            std::fprintf(stderr, "\r%3.0f %% %-12s", 100 * done, stage);
            return true;
        });
        const neural_mesh::Result light = job.run();
        light.write(out, true);
        std::printf("\n%zu triangles\n", light.arrays().index_count / 3);
    } catch (const neural_mesh::Error &error) {
        return std::fprintf(stderr, "\n%s\n", error.what()), 1;
    }
    return 0;
}

// Tests the wrapper of neural_mesh.hpp: results, exceptions, threads.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "neural_mesh.hpp"

#define CHECK(what) \
    do { \
        if (!(what)) std::fprintf(stderr, "%s:%d: %s is false\n", __FILE__, __LINE__, #what), std::exit(1); \
    } while (0)

static std::string catch_error(const std::function<void()> &work) {
    try {
        work();
    } catch (const neural_mesh::Error &error) {
        return error.what();
    }
    return "";
}

int main() {
    const std::uint32_t n = 60;
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i <= n; i++)
        for (std::uint32_t j = 0; j <= n; j++) {
            const float x = float(i) / n, y = float(j) / n;
            positions.insert(positions.end(), {x, y, 0.2f * std::sin(5 * x) * std::cos(4 * y)});
            const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
            if (i < n && j < n) indices.insert(indices.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    float error = 0;
    const auto light = neural_mesh::simplify(indices, positions.data(), positions.size() / 3, 12, 600, 1, NM_LOCK_BORDER, &error);
    CHECK(light.size() <= 1200 && light.size() % 3 == 0 && error > 0);
    CHECK(!catch_error([&] { neural_mesh::simplify(indices, nullptr, 10, 12, 600, 1); }).empty());

    neural_mesh::Job job;
    job.read_arrays(positions.data(), positions.size() / 3, 12, indices.data(), indices.size()).set("faces", "500").set("format", "glb");
    const auto result = job.run();
    // An open sheet may end a triangle below.
    const auto n_indices = result.arrays().index_count;
    CHECK((n_indices == 1500 || n_indices == 1497) && result.bytes().size() > 1000);
    CHECK(catch_error([&] { job.set("faces", "many").run(); }).find("many") != std::string::npos);
    job.set("faces", "500");
    job.listen([](float, const char *) -> bool { throw 1; });
    CHECK(!catch_error([&] { job.run(); }).empty());

    // Each thread has its own last error, and jobs run side by side.
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; t++)
        threads.emplace_back([&, t] {
            neural_mesh::Job own;
            own.read_arrays(positions.data(), positions.size() / 3, 12, indices.data(), indices.size()).set("faces", std::to_string(400 + 100 * t));
            const auto n_faces = own.run().arrays().index_count / 3;
            CHECK(n_faces == 400u + 100 * t || n_faces + 1 == 400u + 100 * t);
            CHECK(catch_error([&] { own.set("x" + std::to_string(t), "1"); }).find("option: x" + std::to_string(t)) != std::string::npos);
        });
    for (auto &thread : threads) thread.join();
    std::puts("all tests passed");
    return 0;
}

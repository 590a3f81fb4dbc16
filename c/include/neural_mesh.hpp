// neural-mesh for C++17: a wrapper of `neural_mesh.h` with exceptions for errors, and handles that free themselves.
// SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef NEURAL_MESH_HPP
#define NEURAL_MESH_HPP

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "neural_mesh.h"

namespace neural_mesh {

// Error of a call; `what()` is one line.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

namespace detail {
template <class T> T checked(T value, T failed) {
    if (value == failed) throw Error(nm_last_error());
    return value;
}
} // namespace detail

// Positions and triangles of a result, which last as long as it does.
struct Arrays {
    const float *positions;
    std::size_t vertex_count;
    const std::uint32_t *indices;
    std::size_t index_count;
};

// Result of a job.
class Result {
public:
    explicit Result(nm_result *handle) : handle_(handle, nm_result_free) {}

    std::size_t levels() const { return detail::checked(nm_result_levels(handle_.get()), std::size_t(0)); }
    // The report as JSON.
    std::string report() const { return detail::checked(nm_result_report(handle_.get()), (const char *)nullptr); }
    Arrays arrays(std::size_t level = 0) const {
        Arrays a{};
        detail::checked(
            nm_result_arrays(handle_.get(), level, &a.positions, &a.vertex_count, &a.indices, &a.index_count), 0);
        return a;
    }
    // The bytes of a level's file, in the format of the option `format`.
    std::vector<unsigned char> bytes(std::size_t level = 0) const {
        std::size_t n = 0;
        auto *first = static_cast<const unsigned char *>(
            detail::checked(nm_result_bytes(handle_.get(), level, &n), (const void *)nullptr));
        return std::vector<unsigned char>(first, first + n);
    }
    void write(const std::string &path, bool force = false, std::size_t level = 0) const {
        detail::checked(nm_result_write(handle_.get(), level, path.c_str(), force), 0);
    }

private:
    std::unique_ptr<nm_result, void (*)(nm_result *)> handle_;
};

// A job: a mesh to simplify, and options.
class Job {
public:
    // Receives the progress of a run; `false` ends it.
    using Progress = std::function<bool(float done, const char *stage)>;

    Job() : handle_(detail::checked(nm_job_new(), (nm_job *)nullptr), nm_job_free) {}

    Job &set(const std::string &name, const std::string &value) {
        return checked(nm_job_set(handle_.get(), name.c_str(), value.c_str()));
    }
    Job &read_file(const std::string &path) { return checked(nm_job_read_file(handle_.get(), path.c_str())); }
    Job &read_bytes(const void *data, std::size_t n, const std::string &name = "") {
        return checked(nm_job_read_bytes(handle_.get(), data, n, name.c_str()));
    }
    Job &read_arrays(const float *positions, std::size_t vertex_count, std::size_t stride, const std::uint32_t *indices,
                     std::size_t index_count) {
        return checked(nm_job_read_arrays(handle_.get(), positions, vertex_count, stride, indices, index_count));
    }
    Job &listen(Progress progress) {
        progress_ = std::make_unique<Progress>(std::move(progress));
        return checked(nm_job_listen(handle_.get(), call, progress_.get()));
    }
    // Cancels the run, from any thread.
    void cancel() { checked(nm_job_cancel(handle_.get())); }
    Result run() const { return Result(detail::checked(nm_job_run(handle_.get()), (nm_result *)nullptr)); }

private:
    Job &checked(int done) {
        detail::checked(done, 0);
        return *this;
    }
    // No exception may cross the C functions: one ends the run.
    static std::int32_t call(void *user, float done, const char *stage) {
        try {
            return !(*static_cast<Progress *>(user))(done, stage);
        } catch (...) {
            return 1;
        }
    }

    std::unique_ptr<nm_job, void (*)(nm_job *)> handle_;
    std::unique_ptr<Progress> progress_;
};

// Simplifies triangles over these vertices and returns the indices; `error` receives the distance from the original.
inline std::vector<std::uint32_t> simplify(const std::vector<std::uint32_t> &indices, const float *positions,
                                           std::size_t vertex_count, std::size_t stride, std::size_t target_index_count,
                                           float target_error, std::uint32_t options = 0, float *error = nullptr) {
    std::vector<std::uint32_t> result(indices.size());
    result.resize(detail::checked(nm_simplify(result.data(), indices.data(), indices.size(), positions, vertex_count, stride,
                                              target_index_count, target_error, options, error),
                                  std::size_t(NM_FAILED)));
    return result;
}

} // namespace neural_mesh

#endif

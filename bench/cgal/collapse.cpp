// Simplifies a mesh by CGAL's edge collapse: what `lab` measures neural-mesh against beside meshoptimizer.
//
//   collapse qem|lt IN.ply OUT.ply FACES
//
// qem: quadrics with optimal placement (Garland and Heckbert 1997), with CGAL's bound on the change of normals, as in its
// example. lt: memoryless volume and boundary (Lindstrom and Turk 1998, 1999), CGAL's default. Prints the seconds of the
// processor for the collapse alone. Surfaces that a half-edge mesh cannot hold are made so by CGAL's repair, which is not timed.

#include <CGAL/Polygon_mesh_processing/IO/polygon_mesh_io.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

namespace SMS = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Stops at a number of faces; CGAL 5 counts edges only.
struct Enough {
    std::size_t n_faces;

    template <typename Cost, typename Profile>
    bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
        return profile.surface_mesh().number_of_faces() <= n_faces;
    }
};

// Seconds of the processor.
static double now() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
}

static void by_quadrics(Mesh& mesh, const Enough& enough) {
    using Policies = SMS::GarlandHeckbert_plane_policies<Mesh, Kernel>;
    using Placement = SMS::Bounded_normal_change_placement<Policies::Get_placement>;
    Policies policies(mesh);
    Placement placement(policies.get_placement());
    SMS::edge_collapse(mesh, enough, CGAL::parameters::get_cost(policies.get_cost()).get_placement(placement));
}

int main(int n, char** words) {
    if (n != 5) {
        std::fprintf(stderr, "usage: collapse qem|lt IN.ply OUT.ply FACES\n");
        return 2;
    }
    const std::string method = words[1];
    Mesh mesh;
    if (!CGAL::Polygon_mesh_processing::IO::read_polygon_mesh(words[2], mesh)) {
        std::fprintf(stderr, "%s cannot be read\n", words[2]);
        return 1;
    }
    const Enough enough{std::strtoull(words[4], nullptr, 10)};
    const double began = now();
    if (method == "qem") {
        by_quadrics(mesh, enough);
    } else {
        SMS::edge_collapse(mesh, enough);
    }
    const double took = now() - began;
    mesh.collect_garbage();
    if (!CGAL::IO::write_polygon_mesh(words[3], mesh, CGAL::parameters::stream_precision(17))) {
        std::fprintf(stderr, "%s cannot be written\n", words[3]);
        return 1;
    }
    std::printf("seconds: %.9f\n", took);
    return 0;
}

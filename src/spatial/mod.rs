//! Nearest points: k-nn over points, nearest point on triangles; knows no meshes.

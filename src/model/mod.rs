//! The network of the paper, one file per named thing; sees points, graphs and matrices only.

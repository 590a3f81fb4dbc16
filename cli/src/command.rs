//! The command line and its commands.

use clap::{Parser, Subcommand};

use crate::args::{ClustersArgs, CompareArgs, InfoArgs, LimitsArgs, MeshPointsArgs, ProgressionArgs, SimplifyArgs};
use crate::train::TrainArgs;

/// Simplifies triangle meshes: closed meshes stay closed, and results stay close to the original.
#[derive(Debug, Parser)]
#[command(name = "neural-mesh", version, arg_required_else_help = true)]
pub struct Args {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands of the program.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simplify a mesh
    Simplify(Box<SimplifyArgs>),
    /// Collapse a mesh once, for `simplify` to make any size of it
    Progression(ProgressionArgs),
    /// Make a mesh from a point cloud with a trained network
    MeshPoints(MeshPointsArgs),
    /// Write a hierarchy of clusters, whose level of detail varies over the surface
    Clusters(ClustersArgs),
    /// Describe a mesh: counts, bounds, topology, attributes
    Info(InfoArgs),
    /// Report how far a mesh can be simplified, and what limits it
    Limits(LimitsArgs),
    /// Measure and show how simplified meshes differ from the original
    Compare(CompareArgs),
    Train(TrainArgs),
}

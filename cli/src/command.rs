//! The command line: which commands there are.

use clap::{Parser, Subcommand};

use crate::args::{CompareArgs, InfoArgs, LimitsArgs, MeshPointsArgs, SimplifyArgs};
use crate::train::TrainArgs;

/// Simplifies triangle meshes: closed stays closed, and the result lies close to the original.
#[derive(Debug, Parser)]
#[command(name = "neural-mesh", version, arg_required_else_help = true)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a lighter mesh
    Simplify(Box<SimplifyArgs>),
    /// Mesh a point cloud with a trained network
    MeshPoints(MeshPointsArgs),
    /// Describe a mesh: counts, bounds, closed, manifold, components, genus, what was cleaned
    Info(InfoArgs),
    /// Say how small a mesh gets, how far from the original, and what holds it
    Limits(LimitsArgs),
    /// Measure and show how simplified meshes differ from their original
    Compare(CompareArgs),
    // What it is for stands with its arguments, which a build without it does not have.
    Train(TrainArgs),
}

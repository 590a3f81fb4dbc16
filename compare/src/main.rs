//! Measures neural-mesh against meshoptimizer on mesh files, and writes what came out as Markdown.
//!
//! `closed` and `ablation` make the tables of what the scores and the parts of the closed assembly are worth;
//! `paper`, `samplers-paper` and `figure5` make the tables and the picture of the paper with given weights.
//! `speed` times simplification, one row of ratios per mesh and size; `growth` shows how time and memory grow with the mesh.
//! `textured` makes that of textured models. `run` makes the table of figures, one CSV row per mesh, ratio, seed and method; `memory`, `same-bits` and
//! `broken-files` make small tables of their own; `summary` turns all of them into a page. Simplification is
//! timed on one thread, the methods taking turns in one process; metrics use all threads.

mod ablation;
mod broken_files;
mod certain;
mod check;
mod closed;
mod figure5;
mod files;
mod growth;
mod load;
mod measure;
mod memory;
mod methods;
mod paper;
mod paper_speed;
mod peak;
mod pictures;
mod row;
mod run;
mod same_bits;
mod samplers;
mod samplers_paper;
mod speed;
mod stages;
mod summary;
mod table;
mod textured;
mod turns;
mod whole;

use clap::{Parser, Subcommand};

/// Measure neural-mesh against meshoptimizer.
#[derive(Parser)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simplify meshes with both methods and measure every result.
    Run(run::Args),
    /// Measure what learned scores are worth in the closed assembly.
    Closed(closed::Args),
    /// Measure what each part of the closed assembly is worth.
    Ablation(closed::Args),
    /// Measure the peak memory of the program on one mesh.
    Memory(memory::Args),
    /// Check that results do not depend on threads and are the same on a second run.
    SameBits(same_bits::Args),
    /// Give the program every file of a folder of broken ones.
    BrokenFiles(broken_files::Args),
    /// Find the smallest meshes that certainly lie within a distance.
    Certain(certain::Args),
    /// Hold the distance that the program says against that of many samples.
    Check(check::Args),
    /// Draw meshes before and after, by both methods, and write the page that shows them.
    Pictures(pictures::Args),
    /// Draw the paper's Figure 5: weights before and after fine-tuning for curvature.
    Figure5(figure5::Args),
    /// Make the paper's table: its pipeline against QEM and meshoptimizer.
    Paper(paper::Args),
    /// Time the paper's assembly, stage by stage.
    PaperSpeed(paper_speed::Args),
    /// Compare ways to draw the sampled vertices.
    Samplers(samplers::Args),
    /// Make the paper's table of samplers: the drawn vertices as a set of points.
    SamplersPaper(samplers_paper::Args),
    /// Show where the time goes, stage by stage.
    Stages(stages::Args),
    /// Measure textured models, with pictures of their textures, against meshoptimizer with attributes.
    Textured(textured::Args),
    /// Time simplification: ours and meshoptimizer's three, taking turns.
    Speed(speed::Args),
    /// Show how time and memory grow with the mesh.
    Growth(growth::Args),
    /// Time reading, cleaning and writing.
    Files(files::Args),
    /// Time the whole program, from file to file, against one around meshoptimizer.
    Whole(whole::Args),
    /// The program around meshoptimizer.
    #[command(hide = true)]
    WholeOther(whole::OtherArgs),
    /// Write the tables as Markdown.
    Summary(summary::Args),
}

fn main() -> anyhow::Result<()> {
    match Args::parse().command {
        Command::Run(args) => run::run(&args),
        Command::Closed(args) => closed::closed(&args),
        Command::Ablation(args) => ablation::ablation(&args),
        Command::Memory(args) => memory::memory(&args),
        Command::SameBits(args) => same_bits::same_bits(&args),
        Command::BrokenFiles(args) => broken_files::broken_files(&args),
        Command::Certain(args) => certain::certain(&args),
        Command::Check(args) => check::check(&args),
        Command::Pictures(args) => pictures::pictures(&args),
        Command::Figure5(args) => figure5::figure5(&args),
        Command::Paper(args) => paper::paper(&args),
        Command::PaperSpeed(args) => paper_speed::paper_speed(&args),
        Command::Samplers(args) => samplers::samplers(&args),
        Command::SamplersPaper(args) => samplers_paper::samplers_paper(&args),
        Command::Stages(args) => stages::stages(&args),
        Command::Textured(args) => textured::textured(&args),
        Command::Speed(args) => speed::speed(&args),
        Command::Growth(args) => growth::growth(&args),
        Command::Files(args) => files::files(&args),
        Command::Whole(args) => whole::whole(&args),
        Command::WholeOther(args) => whole::other(&args),
        Command::Summary(args) => summary::summary(&args),
    }
}

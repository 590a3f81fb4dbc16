//! Checks `.meshlet_mesh` files with Bevy's loader and saver, without a window or a GPU.
//!
//! `meshlets FILE...` loads each file, saves it by Bevy's saver, compares the arrays of both, checks the tree as Bevy's shaders walk
//! it, and expects Bevy to refuse damaged copies. Prints a line per file. Exit code 1 if a check fails.

mod content;
mod cuts;
mod damage;
mod server;
mod tree;

use std::process::ExitCode;

use content::Content;
use server::Server;
use tree::Tree;

fn main() -> ExitCode {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    if paths.is_empty() {
        eprintln!("usage: meshlets FILE...");
        return ExitCode::from(2);
    }
    let mut server = Server::new();
    let mut code = ExitCode::SUCCESS;
    for path in paths {
        match check_file(&mut server, &path) {
            Ok(summary) => println!("{path}: {summary}"),
            Err(error) => {
                eprintln!("{path}: {error}");
                code = ExitCode::FAILURE;
            }
        }
    }
    code
}

/// Runs all checks on a file; returns what was found.
///
/// # Errors
/// Message about the first check that fails.
fn check_file(server: &mut Server, path: &str) -> Result<String, String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let mesh = server.load(&bytes)?;
    let given = Content::decode(&bytes)?;
    let saved = Content::decode(&server::save(&mesh)?)?;
    if let Some(name) = given.find_difference(&saved) {
        return Err(format!("Bevy's saver writes other {name}"));
    }
    // Bevy's fields are private, so its data are checked in what it saved.
    let tree = Tree::new(&saved)?;
    tree.check_bounds()?;
    saved.check_meshlets()?;
    let cuts = cuts::check_cuts(&saved, &tree)?;
    let n_refused = damage::check_damaged_copies(server, &bytes)?;
    let n_meshlets = saved.n_meshlets();
    Ok(format!(
        "equal after Bevy's loader and saver; {n_meshlets} meshlets; {cuts}; {n_refused} damaged copies refused"
    ))
}

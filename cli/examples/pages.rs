//! Writes completions and man pages of the program into a folder: `pages OUTDIR DATE`.

use std::io::Result;
use std::path::Path;
use std::process::ExitCode;

use clap::Command;
use clap_complete::{Shell, generate_to};
use clap_mangen::Man;

const NAME: &str = "neural-mesh";
const SHELLS: [Shell; 4] = [Shell::Bash, Shell::Fish, Shell::PowerShell, Shell::Zsh];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, date] = &arguments[..] else {
        eprintln!("usage: pages OUTDIR DATE, the date as 2026-01-31");
        return ExitCode::from(2);
    };
    match write(Path::new(folder), date) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{folder}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Writes `completions/` with a file per shell, and `man/` with a page for the program and each command.
fn write(folder: &Path, date: &str) -> Result<()> {
    let (completions, man) = (folder.join("completions"), folder.join("man"));
    std::fs::create_dir_all(&completions)?;
    std::fs::create_dir_all(&man)?;
    for shell in SHELLS {
        let path = generate_to(shell, &mut shown_commands(), NAME, &completions)?;
        if shell == Shell::Bash {
            // Some labels have the hyphen of the name as a step to a subcommand, and nothing would be completed.
            let script = std::fs::read_to_string(&path)?;
            std::fs::write(&path, script.replace("neural__subcmd__mesh__", "neural__mesh__"))?;
        }
    }
    let mut program = shown_commands().disable_help_subcommand(true);
    program.build();
    for command in program.get_subcommands() {
        page(command, &man, date)?;
    }
    page(&program, &man, date)
}

fn page(command: &Command, folder: &Path, date: &str) -> Result<()> {
    let source = concat!("neural-mesh ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).date(date).source(source).manual("User Commands");
    let mut page = Vec::new();
    man.render(&mut page)?;
    std::fs::write(folder.join(man.get_filename()), without_double_breaks(&String::from_utf8_lossy(&page)))
}

/// Removes line breaks next to blank lines, of which mandoc warns.
fn without_double_breaks(page: &str) -> String {
    let lines: Vec<&str> = page.lines().collect();
    let is_blank = |i: Option<usize>| i.and_then(|i| lines.get(i)).is_some_and(|line| line.is_empty());
    let is_kept = |i: usize| lines[i] != ".br" || !is_blank(i.checked_sub(1)) && !is_blank(Some(i + 1));
    (0..lines.len()).filter(|&i| is_kept(i)).map(|i| format!("{}\n", lines[i])).collect()
}

fn shown_commands() -> Command {
    let all = neural_mesh_cli::command_line();
    let commands: Vec<_> = all.get_subcommands().filter(|command| !command.is_hide_set()).cloned().collect();
    let shown = Command::new(NAME).version(env!("CARGO_PKG_VERSION")).subcommand_required(true);
    shown.about(all.get_about().cloned().unwrap_or_default()).subcommands(commands)
}

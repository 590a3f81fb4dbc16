//! Options in Python's types, in JavaScript's types and on the page of options are those of the list, `job::Arguments`.
//!
//! With `NEURAL_MESH_TABLES=write` the tests rewrite what differs.

use std::any::TypeId;
use std::path::Path;

use clap::{Arg, ArgAction, Args, Command};
use neural_mesh::job::{Arguments, Bound, Caller, RatioOf, Size, respell_options};

/// Lines between which a file is made.
const START: &str = "made from the list of options: start";
const END: &str = "made from the list of options: end";
/// Sizes of the result, of which one is given.
const SIZES: [&str; 5] = ["ratio", "vertices", "faces", "error", "size"];

/// Kind of an option's value.
#[derive(Clone, PartialEq)]
enum ValueKind {
    Flag,
    /// One of these names.
    Choice(Vec<String>),
    /// Number, or text such as `10%`.
    Amount,
    /// Whole number, or text such as `10k`.
    WholeAmount,
    Number,
    Whole,
    Text,
}

/// One option of the list.
struct ListedOption {
    /// Name on the command line, without dashes.
    long: String,
    kind: ValueKind,
    is_list: bool,
    /// True if the option may be given without its value.
    is_optional: bool,
    default: Option<String>,
    help: String,
    heading: String,
}

impl ListedOption {
    fn new(arg: &Arg) -> Self {
        let range = arg.get_num_args().unwrap_or_default();
        let default = arg.get_default_values().first().map(|value| value.to_string_lossy().into_owned());
        let is_flag = matches!(arg.get_action(), ArgAction::SetTrue);
        Self {
            long: arg.get_long().unwrap().into(),
            kind: value_kind(arg),
            is_list: matches!(arg.get_action(), ArgAction::Append),
            is_optional: !is_flag && range.min_values() == 0,
            default: default.filter(|_| !is_flag),
            // The program's help says what its build compresses.
            help: if arg.get_id() == "compress" {
                "Write a compressed glTF, as gltfpack does; `quantize` only quantises it".into()
            } else {
                arg.get_help().unwrap().to_string()
            },
            heading: arg.get_help_heading().unwrap_or("Size and format").into(),
        }
    }

    fn name(&self) -> String {
        self.long.replace('-', "_")
    }
}

fn value_kind(arg: &Arg) -> ValueKind {
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        return ValueKind::Flag;
    }
    let names: Vec<String> = arg.get_possible_values().iter().map(|value| value.get_name().into()).collect();
    let value = arg.get_value_parser().type_id();
    let is = |types: &[TypeId]| types.iter().any(|kind| value == *kind);
    match arg.get_id().as_str() {
        _ if !names.is_empty() => ValueKind::Choice(names),
        "lods" => ValueKind::Amount,
        "size" => ValueKind::WholeAmount,
        _ if is(&[TypeId::of::<RatioOf>(), TypeId::of::<Bound>()]) => ValueKind::Amount,
        _ if is(&[TypeId::of::<Size>()]) => ValueKind::WholeAmount,
        _ if is(&[TypeId::of::<f64>()]) => ValueKind::Number,
        _ if is(&[TypeId::of::<usize>(), TypeId::of::<u64>()]) => ValueKind::Whole,
        _ => ValueKind::Text,
    }
}

fn list_options() -> Vec<ListedOption> {
    let command = Arguments::augment_args(Command::new("options"));
    command.get_arguments().map(ListedOption::new).collect()
}

/// Compares the lines between the marks of a file, or the whole file, with `expected`.
#[track_caller]
fn check_file(path: &str, expected: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let after_mark = |mark: &str| text.find(mark).map(|at| at + text[at..].find('\n').unwrap() + 1);
    let made = after_mark(START).map(|start| start..text.find(END).map_or(0, |at| text[..at].rfind('\n').unwrap() + 1));
    let made = made.unwrap_or(0..text.len());
    if text[made.clone()] == *expected {
        return;
    }
    assert!(
        std::env::var_os("NEURAL_MESH_TABLES").is_some_and(|value| value == "write"),
        "{}: differs from the list of options: run this test with NEURAL_MESH_TABLES=write",
        path.display()
    );
    std::fs::write(&path, [&text[..made.start], expected, &text[made.end..]].concat()).unwrap();
}

fn python_type(option: &ListedOption) -> String {
    let quote = |name: &String| format!("\"{name}\"");
    let value = match &option.kind {
        ValueKind::Flag => return "bool".into(),
        ValueKind::Choice(names) => format!("Literal[{}]", names.iter().map(quote).collect::<Vec<_>>().join(", ")),
        ValueKind::Amount => "Number | str".into(),
        ValueKind::WholeAmount => "Whole | str".into(),
        ValueKind::Number => "Number".into(),
        ValueKind::Whole => "Whole".into(),
        ValueKind::Text => "str".into(),
    };
    match option {
        ListedOption { is_list: true, .. } if !SIZES.contains(&&*option.long) => format!("Sequence[{value}] | None"),
        ListedOption { is_optional: true, .. } => format!("bool | {value}"),
        _ => format!("{value} | None"),
    }
}

/// Names an option in Python, where options are positive and no keywords; `None` for those of functions and files.
fn python_name(option: &ListedOption) -> Option<String> {
    match &*option.name() {
        "lods" | "lods_by" | "format" | "weights" | "importance" => None,
        "for" => Some("for_".into()),
        name => Some(name.trim_start_matches("no_").into()),
    }
}

#[test]
fn options_of_python_are_those_of_the_list() {
    let options = list_options();
    let mut classes = String::from("class Sizes(TypedDict, total=False):\n");
    classes += "    \"\"\"Sizes of the result, of which exactly one is given.\"\"\"\n\n";
    for name in SIZES {
        let option = options.iter().find(|option| option.long == name).unwrap();
        classes += &format!("    {name}: {}\n", python_type(option));
    }
    classes += "\n\nclass JobOptions(TypedDict, total=False):\n    \"\"\"Options of the simplifier.\"\"\"\n\n";
    for option in options.iter().filter(|option| !SIZES.contains(&&*option.long)) {
        // Welding is one option: on, off, or a distance.
        if let Some(name) = python_name(option).filter(|_| option.long != "no-weld") {
            let of_weld = "bool | Number | str".to_string();
            let kind = if name == "weld" { of_weld } else { python_type(option) };
            classes += &format!("    {name}: {kind}\n");
        }
    }
    check_file("python/neural_mesh/_options.py", &(classes + "\n\n"));
}

fn typescript_type(option: &ListedOption) -> String {
    let quote = |name: &String| format!("'{name}'");
    let value = match &option.kind {
        ValueKind::Flag => return "boolean".into(),
        ValueKind::Choice(names) => names.iter().map(quote).collect::<Vec<_>>().join(" | "),
        ValueKind::Amount | ValueKind::WholeAmount => "Amount".into(),
        ValueKind::Number | ValueKind::Whole => "number".into(),
        ValueKind::Text => "string".into(),
    };
    match option {
        ListedOption { is_list: true, kind: ValueKind::Choice(_), .. } => format!("({value})[]"),
        ListedOption { is_list: true, .. } if option.long != "ratio" => format!("{value}[]"),
        ListedOption { is_optional: true, .. } => format!("boolean | {value}"),
        _ => value,
    }
}

#[test]
fn options_of_javascript_are_those_of_the_list() {
    let mut members = String::new();
    // The package reads no network, and cannot bake.
    for option in list_options().iter().filter(|option| !["weights", "bake"].contains(&&*option.long)) {
        // Shares by name are another option there.
        let help = option.help.split(" NAME=R").next().unwrap_or_default().trim_end_matches('.');
        let help = respell_options(help, Caller::JavaScript);
        let default = option.default.as_ref().map_or_else(String::new, |default| format!(" [default: {default}]"));
        members += &format!("  /** {help}{default}. */\n  {}?: {};\n", option.name(), typescript_type(option));
    }
    check_file("web/package/types/index.d.ts", &members);
}

fn shown_values(option: &ListedOption) -> String {
    let value = match &option.kind {
        ValueKind::Flag => return String::new(),
        ValueKind::Choice(names) => names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        ValueKind::Amount => "number, or text such as 10%".into(),
        ValueKind::WholeAmount => "whole number, or text such as 10k".into(),
        ValueKind::Number => "number".into(),
        ValueKind::Whole => "whole number".into(),
        ValueKind::Text => "text".into(),
    };
    let value = if option.is_optional { format!("{value}, or none") } else { value };
    option.default.as_ref().map_or(value.clone(), |default| format!("{value} (default: `{default}`)"))
}

#[test]
fn the_page_of_options_is_that_of_the_list() {
    let mut page = String::from("# Options\n\nPython, JavaScript and C write `_` for `-`.\n");
    let options = list_options();
    let mut headings: Vec<&str> = options.iter().map(|option| &*option.heading).collect();
    headings.dedup();
    for heading in headings {
        page += &format!("\n## {heading}\n\n| option | value | effect |\n|---|---|---|\n");
        for option in options.iter().filter(|option| option.heading == heading) {
            page += &format!("| `--{}` | {} | {} |\n", option.long, shown_values(option), option.help);
        }
    }
    check_file("docs/options.md", &page);
}

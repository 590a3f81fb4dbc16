//! The compared methods by name.

use super::tool::Tool;
use crate::baselines::Baseline;
use crate::learned_baselines::LearnedBaseline;
use crate::rows::distinct;
use neural_mesh::simplify::{ClosedOptions, Effort, Optimize, Options, PaperOptions, ScoreSource, Size};
use neural_mesh_cli::shared::Failure;

/// A compared method.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Method {
    /// One of neural-mesh, by its name.
    Ours(&'static str),
    /// A baseline.
    Baseline(Baseline),
    /// A learned baseline.
    Learned(LearnedBaseline),
    /// An external program.
    Tool(Tool),
}

type SetOptions = fn(&mut ClosedOptions);

/// Our closed methods with the options that they set.
const CLOSED: [(&str, SetOptions); 10] = [
    ("closed", |_| ()),
    ("network", |options| options.scores = ScoreSource::Network),
    ("geometry", |options| options.scores = ScoreSource::Geometry),
    ("mean", |options| options.optimize = Optimize::Mean),
    ("max", |options| options.optimize = Optimize::Max),
    ("normals", |options| options.optimize = Optimize::Normals),
    ("looks", |options| options.optimize = Optimize::Looks),
    ("fast", |options| options.effort = Effort::Fast),
    ("best", |options| options.effort = Effort::Best),
    ("best-mean", |options| (options.optimize, options.effort) = (Optimize::Mean, Effort::Best)),
];

/// The paper's assembly: whether holes are closed, and vertices placed.
const PAPER: [(&str, [bool; 2]); 4] = [
    ("paper", [false, false]),
    ("paper-closed", [true, false]),
    ("paper-placed", [true, true]),
    ("paper-quotient", [false, false]),
];

/// Lists the names of our methods.
fn ours() -> impl Iterator<Item = &'static str> {
    CLOSED.iter().map(|(name, _)| *name).chain(PAPER.iter().map(|(name, _)| *name))
}

/// Returns the options of one of our methods.
pub(super) fn options(name: &str, target: Size, seed: u64) -> Options {
    if let Some(&(_, [close, place])) = PAPER.iter().find(|(paper, _)| *paper == name) {
        return Options::with_paper(target, PaperOptions { seed, close, place, ..PaperOptions::default() });
    }
    let mut closed = ClosedOptions::default();
    CLOSED.iter().filter(|(own, _)| *own == name).for_each(|(_, set)| set(&mut closed));
    Options::with_closed(target, closed)
}

impl Method {
    /// Returns the names of all methods except tools, ours first.
    pub fn names() -> Vec<&'static str> {
        let baselines = Baseline::ALL.map(Baseline::name);
        let learned = LearnedBaseline::ALL.map(LearnedBaseline::name);
        ours().chain(baselines).chain(learned).collect()
    }

    /// Returns the method of a name, except tools.
    pub fn from_name(name: &str) -> Option<Self> {
        let ours = ours().find(|ours| *ours == name).map(Self::Ours);
        let baseline = || Baseline::from_name(name).map(Self::Baseline);
        let learned = || LearnedBaseline::from_name(name).map(Self::Learned);
        ours.or_else(baseline).or_else(learned)
    }

    /// Returns the name in tables and arguments.
    pub fn name(&self) -> &str {
        match self {
            Self::Baseline(baseline) => baseline.name(),
            Self::Learned(baseline) => baseline.name(),
            Self::Tool(tool) => &tool.name,
            Self::Ours(name) => name,
        }
    }

    pub(super) fn is_paper(&self) -> bool {
        matches!(self, Self::Ours(name) if name.starts_with("paper"))
    }

    /// Returns whether the method is ours.
    pub fn is_ours(&self) -> bool {
        matches!(self, Self::Ours(_))
    }
}

/// Returns the methods of these names, each once; `all` means every named method.
pub(super) fn choose_methods(names: &[String], tools: &[Tool]) -> Result<Vec<Method>, Failure> {
    check_tools(tools)?;
    let tool = |name: &str| tools.iter().find(|tool| tool.name == name).cloned().map(Method::Tool);
    let mut methods: Vec<Method> = Vec::new();
    for name in names {
        let named: Vec<&str> = if name == "all" { Method::names() } else { vec![name] };
        for name in named {
            let method = Method::from_name(name).or_else(|| tool(name)).ok_or_else(|| unknown(name, tools))?;
            methods.push(method);
        }
    }
    Ok(distinct(methods.into_iter().chain(tools.iter().cloned().map(Method::Tool))))
}

fn check_tools(tools: &[Tool]) -> Result<(), Failure> {
    for (index, Tool { name, .. }) in tools.iter().enumerate() {
        let taken = name == "all" || Method::from_name(name).is_some();
        if taken || tools[..index].iter().any(|other| other.name == *name) {
            return Err(Failure::Usage(format!("tool {name}: the name is taken: choose another")));
        }
    }
    Ok(())
}

fn unknown(name: &str, tools: &[Tool]) -> Failure {
    let tools = tools.iter().map(|tool| tool.name.as_str());
    let known: Vec<&str> = Method::names().into_iter().chain(tools).chain(["all"]).collect();
    Failure::Usage(format!("unknown method {name}: choose from {}", known.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(asked: &[&str], tools: &[Tool]) -> Vec<String> {
        let asked: Vec<String> = asked.iter().map(|name| name.to_string()).collect();
        choose_methods(&asked, tools).unwrap().iter().map(|method| method.name().to_string()).collect()
    }

    #[test]
    fn every_method_has_its_name() {
        for name in Method::names() {
            assert_eq!(Method::from_name(name).unwrap().name(), name);
        }
    }

    #[test]
    fn each_takes_part_once_in_the_order_asked_for() {
        let tools = [Tool::parse("mine=cp {in} {out}").unwrap()];
        assert_eq!(names(&["qem", "paper", "qem"], &tools), ["qem", "paper", "mine"]);
        assert_eq!(names(&["mine", "qem"], &tools), ["mine", "qem"]);
        assert_eq!(names(&["all"], &tools).len(), Method::names().len() + 1);
    }

    #[test]
    fn unknown_names_and_names_taken_are_refused() {
        let error = choose_methods(&["magic".into()], &[]).unwrap_err().to_string();
        assert!(error.contains("magic") && error.contains("qem"), "{error}");
        let tool = |name: &str| Tool { name: name.into(), command: "cp {in} {out}".into() };
        assert!(choose_methods(&[], &[tool("qem")]).is_err());
        assert!(choose_methods(&[], &[tool("a"), tool("a")]).is_err());
    }
}

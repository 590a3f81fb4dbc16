//! The ratios as a Markdown table, line by line as they come.

use super::contestant::Contestant;
use super::{Case, Measured, Spread};

/// The table so far.
pub struct Page {
    cases: Vec<Case>,
    names: Vec<String>,
    distance: bool,
}

impl Page {
    /// Prints what the columns are.
    pub fn new(contestants: &[Contestant], distance: bool) -> Self {
        let names: Vec<String> = contestants.iter().map(|contestant| contestant.name.clone()).collect();
        let others = names[1..].iter().map(|name| format!(" {name} |")).collect::<String>();
        println!(
            "Times divided by that of meshoptimizer's `simplify` (plain) in the same round: median (least to largest)."
        );
        if distance {
            println!("After the semicolon, mean distance from the original divided by that of plain.");
        }
        println!("\n| mesh | faces | ratio | plain, ns per face |{others}");
        println!("|---|---|---|---|{}", "---|".repeat(names.len() - 1));
        Self { cases: Vec::new(), names, distance }
    }

    /// Prints the row of a case and remembers it.
    pub fn tell(&mut self, case: Case) {
        let plain = &case.measured[0];
        let per_face = 1e9 * plain.seconds.median / case.n_faces as f64;
        let cell = |measured: &Measured| format!(" {}{} |", measured.relative, self.distance_of(measured, plain));
        let cells: String = case.measured[1..].iter().map(cell).collect();
        println!("| {} | {} | {} | {per_face:.0} |{cells}", case.mesh, case.n_faces, case.ratio);
        self.cases.push(case);
    }

    fn distance_of(&self, measured: &Measured, plain: &Measured) -> String {
        match (measured.distance, plain.distance) {
            (Some(own), Some(plain)) => format!("; {:.3}", own / plain),
            _ => String::new(),
        }
    }

    /// Prints the medians over all cases.
    pub fn tell_medians(&self) {
        let median = |place: usize| Spread::of(self.cases.iter().map(|c| c.measured[place].relative.median).collect());
        let distance = |place: usize| {
            let of = |c: &Case| Some(c.measured[place].distance? / c.measured[0].distance?);
            let all = Spread::of(self.cases.iter().filter_map(of).collect());
            if self.distance { format!("; {:.3}", all.median) } else { String::new() }
        };
        let cells: String = (1..self.names.len()).map(|i| format!(" **{}**{} |", median(i), distance(i))).collect();
        println!("| **all** | | | |{cells}");
    }
}

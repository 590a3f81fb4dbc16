//! Options by name, as people type them.

use neural_mesh::job::Arguments;
use serde_json::{Map, Value};

use crate::errors::Refused;

/// Options whose values are lists, with commas in between.
const LISTS: [&str; 3] = ["keep", "ignore", "lods"];

/// Options as they were set.
#[derive(Clone, Default)]
pub struct Options {
    values: Map<String, Value>,
}

impl Options {
    /// Sets an option; refuses one that is unknown or of another kind.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Refused> {
        let mut with = self.values.clone();
        with.insert(name.into(), read(name, value));
        serde_json::from_value::<Arguments>(Value::Object(with.clone()))
            .map_err(|error| Refused(format!("{name}={value}: {error}")))?;
        self.values = with;
        Ok(())
    }

    /// Returns them as the library has them.
    pub fn arguments(&self) -> Result<Arguments, Refused> {
        Ok(serde_json::from_value(Value::Object(self.values.clone()))?)
    }
}

/// A value as JSON where it is such, else as text.
fn read(name: &str, value: &str) -> Value {
    let one = |text: &str| match serde_json::from_str(text.trim()) {
        Ok(known @ (Value::Bool(_) | Value::Number(_) | Value::Object(_) | Value::Array(_))) => known,
        _ => Value::from(text.trim()),
    };
    match one(value) {
        list @ Value::Array(_) => list,
        _ if LISTS.contains(&name) => value.split(',').map(one).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_as_they_are_typed() {
        let mut options = Options::default();
        let said =
            [("ratio", "10%"), ("subset", "true"), ("crease_angle", "40"), ("keep", "wheel, door"), ("seed", "3")];
        said.into_iter().for_each(|(name, value)| options.set(name, value).unwrap());
        let arguments = options.arguments().unwrap();
        assert!(arguments.subset && arguments.crease_angle == Some(40.0) && arguments.seed == 3);
        assert_eq!(arguments.keep, ["wheel", "door"]);
        for (name, value) in [("ration", "0.1"), ("subset", "perhaps"), ("seed", "-1")] {
            assert!(options.set(name, value).is_err(), "{name}");
        }
        assert!(options.arguments().is_ok());
    }
}

//! Options of jobs by name, with values as typed.

use neural_mesh::job::{Arguments, read_options};
use serde_json::{Map, Value};

use crate::errors::CallError;

const LISTS: [&str; 3] = ["keep", "ignore", "lods"];

#[derive(Clone, Default)]
pub struct NamedOptions {
    values: Map<String, Value>,
}

impl NamedOptions {
    /// Sets an option; rejects unknown names and values of the wrong kind.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), CallError> {
        let mut values = self.values.clone();
        values.insert(name.into(), parse_value(name, value));
        read_options::<Arguments>(Value::Object(values.clone()))?;
        self.values = values;
        Ok(())
    }

    pub fn to_arguments(&self) -> Result<Arguments, CallError> {
        Ok(serde_json::from_value(Value::Object(self.values.clone()))?)
    }
}

/// Parses booleans, numbers, objects and arrays as JSON, other values as text.
fn parse_value(name: &str, value: &str) -> Value {
    let parse_one = |text: &str| match serde_json::from_str(text.trim()) {
        Ok(known @ (Value::Bool(_) | Value::Number(_) | Value::Object(_) | Value::Array(_))) => known,
        _ => Value::from(text.trim()),
    };
    match parse_one(value) {
        list @ Value::Array(_) => list,
        _ if LISTS.contains(&name) => value.split(',').map(parse_one).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_as_they_are_typed() {
        let mut options = NamedOptions::default();
        let pairs =
            [("ratio", "10%"), ("subset", "true"), ("crease_angle", "40"), ("keep", "wheel, door"), ("seed", "3")];
        pairs.into_iter().for_each(|(name, value)| options.set(name, value).unwrap());
        let arguments = options.to_arguments().unwrap();
        assert!(arguments.subset && arguments.crease_angle == Some(40.0) && arguments.seed == 3);
        assert_eq!(arguments.keep, ["wheel", "door"]);
        for (name, value) in [("ration", "0.1"), ("subset", "perhaps"), ("seed", "-1")] {
            assert!(options.set(name, value).is_err(), "{name}");
        }
        assert!(options.to_arguments().is_ok());
    }
}

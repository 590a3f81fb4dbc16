//! Options in JSON, with the parsers of the command line.
//!
//! A value is a number or a text. `false` means that an option is not given; `true` gives an option without its value.

use std::collections::BTreeMap;

use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};
use serde_json::{Number, Value};

use super::choices::Compression;
use super::parse::{self, RatioOf};
use super::size::Bound;
use crate::io::shorten_name;
use crate::simplify::Size;

/// Makes readers of options with a value, which a parser takes.
macro_rules! values {
    ($($name:ident: $parse:path => $value:ty;)*) => {$(
        pub fn $name<'de, D: Deserializer<'de>>(from: D) -> Result<Option<$value>, D::Error> {
            value(from, $parse)
        }
    )*};
}
values! {
    vertices: parse::vertices => Size;
    faces: parse::faces => Size;
    bound: parse::bound => Bound;
    n_bytes: parse::n_bytes => usize;
    degrees: parse::degrees => f64;
    field_of_view: parse::field_of_view => f64;
    seam_texels: parse::seam_texels => f64;
    texture_side: parse::texture_side => usize;
}

/// Makes readers of options whose value may be left out.
macro_rules! optional_values {
    ($($name:ident: $parse:path => $value:ty;)*) => {$(
        pub fn $name<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Option<$value>>, D::Error> {
            optional_value(from, $parse)
        }
    )*};
}
optional_values! {
    optional_bound: parse::bound => Bound;
    optional_n_edges: parse::n_edges => usize;
}

/// Reads a distance; `true` means none, as for welding at equal positions.
pub fn weld_distance<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Bound>, D::Error> {
    optional_bound(from).map(Option::flatten)
}

/// Reads the share of all vertices.
pub fn ratio<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<RatioOf>, D::Error> {
    let whole = |share| RatioOf { name: None, share };
    value(from, parse::share).map(|share| share.map(whole).into_iter().collect())
}

/// Reads shares by name.
pub fn named_shares<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let named = BTreeMap::<String, Value>::deserialize(from)?.into_iter();
    named.map(|(name, of)| parse_text(&value_text(of)?, parse::share).map(|share| (name, share))).collect()
}

/// Reads levels of detail as text, which [`parse`] knows to read with their unit.
pub fn texts<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<String>, D::Error> {
    Vec::<Value>::deserialize(from)?.into_iter().map(value_text).collect()
}

/// Reads a compression by name; `true` is the default.
pub fn compression<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Compression>, D::Error> {
    match Value::deserialize(from)? {
        Value::Null | Value::Bool(false) => Ok(None),
        Value::Bool(true) => Ok(Some(Compression::Meshopt)),
        other => Compression::deserialize(other).map(Some).map_err(D::Error::custom),
    }
}

/// Writes an option whose value may be left out.
pub fn write_optional<T: Serialize, S: Serializer>(given: &Option<Option<T>>, to: S) -> Result<S::Ok, S::Error> {
    match given {
        Some(None) => to.serialize_bool(true),
        given => given.serialize(to),
    }
}

/// Makes values write themselves as they are typed.
macro_rules! write_as_typed {
    ($($value:ty),*) => {$(
        impl Serialize for $value {
            fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.collect_str(self)
            }
        }
    )*};
}
write_as_typed! { Bound, RatioOf }

/// Writes a size as it is typed.
pub fn write_size<S: Serializer>(size: &Option<Size>, to: S) -> Result<S::Ok, S::Error> {
    size.map(|size| size.to_string()).serialize(to)
}

fn value<'de, D: Deserializer<'de>, T>(from: D, parse: fn(&str) -> Result<T, String>) -> Result<Option<T>, D::Error> {
    match optional_value(from, parse)? {
        Some(None) => Err(D::Error::custom("expected a number or a text")),
        given => Ok(given.flatten()),
    }
}

fn optional_value<'de, D: Deserializer<'de>, T>(
    from: D,
    parse: fn(&str) -> Result<T, String>,
) -> Result<Option<Option<T>>, D::Error> {
    match Value::deserialize(from)? {
        Value::Null | Value::Bool(false) => Ok(None),
        Value::Bool(true) => Ok(Some(None)),
        other => parse_text(&value_text(other)?, parse).map(|value| Some(Some(value))),
    }
}

/// Parses a value; the error has the value in backticks before the reason.
fn parse_text<E: Error, T>(text: &str, parse: fn(&str) -> Result<T, String>) -> Result<T, E> {
    parse(text).map_err(|why| E::custom(format!("`{}`: {why}", shorten_name(text))))
}

fn value_text<E: Error>(value: Value) -> Result<String, E> {
    match value {
        Value::String(text) => Ok(text),
        // Without the decimal point that JSON writes for a double that is whole.
        Value::Number(number) => Ok(whole_double(&number).map_or_else(|| number.to_string(), |it| it.to_string())),
        _ => Err(E::custom("expected a number or a text")),
    }
}

fn whole_double(number: &Number) -> Option<f64> {
    number.as_f64().filter(|_| number.is_f64())
}

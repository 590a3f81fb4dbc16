//! JSON and arrays of numbers as one piece of memory.
//!
//! A message holds the number of parts, the bytes of each, zeros up to a multiple of 8, then the parts, each padded to
//! a multiple of 8. Numbers are little-endian, counts `u32`. Part 0 is JSON, which names the others by number.

use std::ops::ControlFlow;

use serde_json::Value;

use crate::refusal::Refusal;

const ALIGNMENT: usize = 8;

/// Parsed request.
pub struct Message<'a> {
    parts: Vec<&'a [u8]>,
}

impl<'a> Message<'a> {
    /// Parses a message.
    ///
    /// # Errors
    /// [`Refusal`] if the bytes are not a message.
    pub fn read(bytes: &'a [u8]) -> Result<Self, Refusal> {
        parts(bytes)
            .map(|parts| Self { parts })
            .ok_or_else(|| Refusal::new("the request is not a message: build the package and the module together"))
    }

    /// Returns a part by its number.
    ///
    /// # Errors
    /// [`Refusal`] if the part is missing.
    pub fn part(&self, number: usize) -> Result<&'a [u8], Refusal> {
        self.parts.get(number).copied().ok_or_else(|| Refusal::new(format!("the request has no part {number}")))
    }

    /// Returns a part as numbers of `N` bytes each.
    ///
    /// # Errors
    /// [`Refusal`] if the part is missing or its length does not fit.
    pub fn numbers<T, const N: usize>(&self, number: usize, of: fn([u8; N]) -> T) -> Result<Vec<T>, Refusal> {
        let (numbers, rest) = self.part(number)?.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(Refusal::new(format!("part {number} of the request ends within a number")));
        }
        Ok(numbers.iter().map(|&bytes| of(bytes)).collect())
    }

    /// Returns a part as rows of `W` numbers of `N` bytes each.
    ///
    /// # Errors
    /// [`Refusal`] if the part is missing or its length does not fit.
    pub fn rows<T: Copy, const N: usize, const W: usize>(
        &self,
        number: usize,
        of: fn([u8; N]) -> T,
    ) -> Result<Vec<[T; W]>, Refusal> {
        let numbers = self.numbers(number, of)?;
        let (rows, rest) = numbers.as_chunks::<W>();
        if !rest.is_empty() {
            return Err(Refusal::new(format!("{} numbers: give {W} for each", numbers.len())));
        }
        Ok(rows.to_vec())
    }
}

fn parts(bytes: &[u8]) -> Option<Vec<&[u8]>> {
    let count = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize);
    let n_parts = count(0)?;
    let mut at = n_parts.checked_add(1)?.checked_mul(4)?.checked_next_multiple_of(ALIGNMENT)?;
    let mut parts = Vec::new();
    for part in 0..n_parts {
        let end = at.checked_add(count(4 + 4 * part)?)?;
        parts.push(bytes.get(at..end)?);
        at = end.checked_next_multiple_of(ALIGNMENT)?;
    }
    Some(parts)
}

/// Progress listener: receives the finished share (0 to 1) of a step and the step's number; `Break` ends the run.
pub type ProgressListener = Box<dyn FnMut(f64, u32) -> ControlFlow<()> + Send>;

/// Arrays of an answer.
#[derive(Default)]
pub struct Answer {
    parts: Vec<Vec<u8>>,
}

impl Answer {
    /// Adds bytes and returns the number of their part, for the JSON.
    pub fn add(&mut self, bytes: Vec<u8>) -> usize {
        self.parts.push(bytes);
        self.parts.len()
    }

    /// Adds numbers of `N` bytes each and returns the number of their part, for the JSON.
    pub fn add_numbers<T, const N: usize>(
        &mut self,
        numbers: impl IntoIterator<Item = T>,
        bytes: fn(T) -> [u8; N],
    ) -> usize {
        self.add(numbers.into_iter().flat_map(bytes).collect())
    }

    /// Joins JSON and arrays into a message.
    pub fn into_bytes(self, json: &Value) -> Vec<u8> {
        let parts: Vec<Vec<u8>> = std::iter::once(json.to_string().into_bytes()).chain(self.parts).collect();
        let sizes = std::iter::once(parts.len()).chain(parts.iter().map(Vec::len));
        let mut bytes: Vec<u8> = sizes.flat_map(|n| (n as u32).to_le_bytes()).collect();
        for part in parts {
            bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
            bytes.extend(part);
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn message_parts_are_restored() {
        let mut answer = Answer::default();
        let numbers = answer.add_numbers([1.5f32, -2.0, 0.0], f32::to_le_bytes);
        let bytes = answer.add(vec![7; 5]);
        let message = answer.into_bytes(&json!({ "numbers": numbers, "bytes": bytes }));
        let read = Message::read(&message).unwrap();
        assert_eq!(
            serde_json::from_slice::<Value>(read.part(0).unwrap()).unwrap(),
            json!({ "numbers": 1, "bytes": 2 })
        );
        assert_eq!(read.rows(numbers, f32::from_le_bytes).unwrap(), [[1.5, -2.0, 0.0]]);
        assert_eq!(read.part(bytes).unwrap(), [7; 5]);
        assert!(read.part(3).is_err() && read.numbers(bytes, u32::from_le_bytes).is_err());
    }

    #[test]
    fn bytes_that_are_no_message_are_refused() {
        let message = Answer { parts: vec![vec![1; 20]] }.into_bytes(&json!({}));
        for end in 0..message.len() {
            assert!(Message::read(&message[..end]).is_err(), "{end}");
        }
        for at in 0..12 {
            let mut broken = message.clone();
            broken[at] = 0xff;
            assert!(Message::read(&broken).is_err(), "{at}");
        }
    }
}

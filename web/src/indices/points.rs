//! Selection of points of a cloud, far from each other.

use neural_mesh::indices::extent;
use neural_mesh::spatial::farthest_latent_points;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::message::{Answer, Message};
use crate::refusal::Refusal;

#[derive(Deserialize)]
struct Cloud {
    positions: usize,
    /// Part with colours, or other numbers per point, that count in distances.
    colors: Option<usize>,
    /// Distance that a colour difference of 1 counts as, relative to the extent.
    #[serde(default)]
    color_weight: f64,
    target: usize,
}

/// Answers with the points that are farthest from each other.
pub fn select_points(message: &Message, json: Value, answer: &mut Answer) -> Result<Value, Refusal> {
    let cloud: Cloud = serde_json::from_value(json)?;
    let positions: Vec<[f32; 3]> = message.rows(cloud.positions, f32::from_le_bytes)?;
    let colors = cloud.colors.map(|part| message.numbers(part, f32::from_le_bytes)).transpose()?.unwrap_or_default();
    if colors.len() % positions.len().max(1) != 0
        || positions.as_flattened().iter().chain(&colors).any(|x| !x.is_finite())
    {
        return Err(Refusal::new("points: give finite numbers, as many for each point"));
    }
    let scale = (cloud.color_weight * extent(&positions)) as f32;
    // Colours are further coordinates of the points, in the unit of the positions.
    let latent: Vec<f32> = colors.iter().map(|x| x * scale).collect();
    let indices = farthest_latent_points(&positions, &latent, cloud.target, 0);
    Ok(json!({ "indices": answer.add_numbers(indices, u32::to_le_bytes) }))
}

//! Check that images can be decoded for a bake.

use std::sync::Arc;

use crate::io::shorten_name;
use crate::mesh::{BaseTexture, Look};
use crate::picture::{decode_image, image_problem};

use super::Document;
use crate::job::error::JobError;
use crate::job::request::Job;

impl Document {
    /// Rejects a document with an undecodable image if the job bakes textures.
    pub fn check_images(self, job: &Job) -> Result<Self, JobError> {
        let Some(size) = job.arguments.bake else { return Ok(self) };
        let (looks, _) = self.looks(job.arguments.allow_outside);
        let mut known: Vec<Arc<[u8]>> = Vec::new();
        for (group, look) in looks.of_groups.iter().enumerate() {
            for BaseTexture { image, .. } in textures(look) {
                if known.iter().any(|other| Arc::ptr_eq(other, image)) {
                    continue;
                }
                if decode_image(image).is_none() {
                    let what = format!("--bake {size}: {} {}", self.material(group), image_problem(image));
                    return Err(JobError::Document(what));
                }
                known.push(image.clone());
            }
        }
        Ok(self)
    }

    fn material(&self, group: usize) -> String {
        let names = self.group_names();
        let name =
            names.iter().find(|(_, of)| *of as usize == group).map(|(name, _)| format!(" {:?}", shorten_name(name)));
        format!("an image of the material{}", name.unwrap_or_default())
    }
}

fn textures(look: &Look) -> impl Iterator<Item = &BaseTexture> {
    let finish = &look.finish;
    let rest = [&finish.emission_texture, &finish.roughness_texture, &finish.metal_texture, &finish.normal_texture];
    std::iter::once(&look.texture).chain(rest).flatten()
}

//! Package of a 3MF, unpacked within limits.

use std::borrow::Cow;
use std::io::{Cursor, Read};

use quick_xml::Reader;
use quick_xml::events::Event;
use zip::ZipArchive;
use zip::result::ZipError;

use super::xml_attribute::attribute;
use crate::io::one_line::one_line;
use crate::io::{ReadError, shorten_name};
use crate::mesh::fallible_allocation::with_fallible_allocation;

/// Largest number of unpacked bytes: the first times the package's bytes, or the second if more.
const LIMIT: (usize, usize) = (200, 16 << 20);

// End of the type of the relation to the model; the start names a year.
const MODEL: &str = "/3dmodel";

const REMEDY: &str = "fetch or export the file again";

pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    most: usize,
    left: usize,
}

impl<'a> Package<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let damaged = |error: ZipError| {
            ReadError::file(format!("the zip data is cut or damaged ({})", one_line(&error.to_string())), REMEDY)
        };
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
        let most = LIMIT.1.max(bytes.len().saturating_mul(LIMIT.0));
        Ok(Self { archive, most, left: most })
    }

    pub fn n_unpacked(&self) -> usize {
        self.most - self.left
    }

    // The relations name the model part; else its extension does.
    pub fn model_part(&mut self) -> Result<String, ReadError> {
        // Broken relations are no error: the extension identifies the model as well.
        let related =
            self.unpack_part("_rels/.rels").ok().and_then(|bytes| model_target(&String::from_utf8_lossy(&bytes)));
        let named = related.filter(|name| self.index(name).is_some());
        let is_model = |name: &&str| name.to_ascii_lowercase().ends_with(".model");
        let found = named.or_else(|| self.archive.file_names().find(is_model).map(String::from));
        found.ok_or_else(|| {
            ReadError::file("the archive contains no 3D model", "give a 3MF file, or unpack the archive")
        })
    }

    pub fn text(&mut self, name: &str) -> Result<String, ReadError> {
        let encoded = |_| ReadError::file(format!("{name} is not in UTF-8"), "export the file again");
        String::from_utf8(self.unpack_part(name)?).map_err(encoded)
    }

    fn unpack_part(&mut self, name: &str) -> Result<Vec<u8>, ReadError> {
        let missing = || ReadError::file(format!("there is no part {:?}", shorten_name(name)), REMEDY);
        // Names ignore case, as the packaging standard demands.
        let index = self.index(name).ok_or_else(missing)?;
        let damaged = |error: String| ReadError::file(format!("{name} is cut or damaged ({error})"), REMEDY);
        let entry = self.archive.by_index(index).map_err(|error| damaged(one_line(&error.to_string())))?;
        let mut bytes = Vec::new();
        let read = with_fallible_allocation(|| entry.take(self.left as u64 + 1).read_to_end(&mut bytes));
        // The size is checked before the error of reading: an oversized part may be damaged as well.
        if bytes.len() > self.left {
            let what = format!("the zip data unpacks to more than {} bytes", self.most);
            return Err(ReadError::file(what, "if you trust the file, unpack it and pack it again"));
        }
        self.left -= bytes.len();
        read.map_err(|error| damaged(one_line(&error.to_string())))?;
        Ok(bytes)
    }

    fn index(&self, name: &str) -> Option<usize> {
        let name = name.trim_start_matches('/');
        let alike = || self.archive.file_names().find(|other| other.eq_ignore_ascii_case(name));
        self.archive.index_for_name(name).or_else(|| self.archive.index_for_name(alike()?))
    }
}

fn model_target(text: &str) -> Option<String> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().ok()? {
            Event::Start(element) | Event::Empty(element)
                if attribute(&element, "Type").is_some_and(|it| it.ends_with(MODEL)) =>
            {
                return attribute(&element, "Target").map(Cow::into_owned);
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

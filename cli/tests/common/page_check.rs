//! Checks of HTML pages.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

pub fn check_page_loads_nothing(page: &str) {
    for (at, scheme) in page.match_indices("http:").chain(page.match_indices("https:")) {
        let address = &page[at..page.len().min(at + 60)];
        // Names of XML namespaces are never loaded.
        assert!(address.starts_with("http://www.w3.org/"), "{scheme} in {address}");
    }
    // The icon is empty and inside the page, so that browsers request none.
    assert_eq!(page.matches("<link").count(), page.matches("<link rel=\"icon\" href=\"data:,\">").count());
    assert!(!page.contains(" src=\"") && !page.contains("@import"));
    assert!(page.contains("default-src 'none'"));
    assert!(page.contains("Permission is hereby granted"), "the licence of three.js is missing");
}

pub fn unpack_numbers(text: &str) -> Vec<u32> {
    let mut bytes = Vec::new();
    flate2::read::DeflateDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
    let mut numbers = Vec::new();
    let (mut number, mut shift) = (0u32, 0);
    for byte in bytes {
        number |= u32::from(byte & 0x7f) << shift;
        shift += 7;
        if byte < 0x80 {
            numbers.push(number);
            (number, shift) = (0, 0);
        }
    }
    assert_eq!(shift, 0);
    numbers
}

//! `nailnoise declare`: the declaration sheet as a page and as a document.

use std::fs;
use std::path::Path;

use crate::common::{SMALL, folder, messages, nailnoise};

/// Printed text, page and document of the small design.
fn declared(folder: &Path, more: &[&str]) -> [String; 3] {
    let out = folder.to_str().unwrap();
    let output = nailnoise(&[&["declare", SMALL, "--out", out], more].concat());
    assert!(output.status.success(), "{}", messages(&output));
    let document = fs::read(folder.join("declaration.docx")).unwrap();
    // A zip archive begins with a local header and ends with its directory; its parts are not compressed.
    assert!(document.starts_with(b"PK\x03\x04") && document.windows(4).any(|four| four == b"PK\x05\x06"));
    [
        String::from_utf8(output.stdout).unwrap(),
        fs::read_to_string(folder.join("declaration.html")).unwrap(),
        String::from_utf8_lossy(&document).into_owned(),
    ]
}

/// The text of the paragraphs of a document, without its marks.
fn plain(document: &str) -> String {
    let mut text = String::new();
    for part in document.split("<w:t ").skip(1) {
        let text_of = part.split_once('>').and_then(|(_, rest)| rest.split_once("</w:t>"));
        text.push_str(text_of.unwrap().0);
    }
    text
}

#[test]
fn the_page_and_the_document_have_the_same_fields() {
    let [text, page, document] = declared(&folder("declare"), &["--rate", "2", "--shots-a-day", "1500"]);
    assert!(
        text.contains("declaration.html") && text.contains("declaration.docx"),
        "{text}"
    );
    let document = plain(&document);
    for part in [
        "small: noise declaration",
        "Declared values (ISO 4871, two-number form)",
        "In use",
        "Operating conditions",
        "Basis",
        "Uncertainty of the levels",
        "2 shots a second",
        "1500 shots",
        "supply pressure, absolute",
        "763.2 kPa",
        "Directive 2003/10/EC",
        "name and signature",
    ] {
        assert!(page.contains(part), "no {part} on the page");
        assert!(document.contains(part), "no {part} in\n{document}");
    }
    // Keys are set as code, without the marks of a plain text.
    assert!(
        document.contains("study.screening") && !document.contains('`'),
        "{document}"
    );
    // Subscripts are runs of their own.
    assert!(page.contains("L<sub>WA,1s,d</sub>") && document.contains("LWA,1s,d"));
}

#[test]
fn the_document_has_the_units_that_are_asked_for() {
    let out = folder("declare-us");
    let [_, page, document] = declared(&out, &["--units", "us"]);
    let document = plain(&document);
    for text in [&page, &document] {
        assert!(
            text.contains("110.69 psi") && !text.contains(" kPa") && !text.contains(" mm"),
            "{text}"
        );
    }
    assert!(document.contains(" lb/ft\u{b3}"), "{document}");
    let report = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(report.contains(" psi absolute") && report.contains("momentum balance [lbf s]"));
    assert!(!report.contains(" W/(m"), "coefficients of heat transfer are in Btu");
    // The position of the ear has one unit.
    assert!(document.contains("ear at x = 0.0, y = 17.7, z = 33.5 in"), "{document}");
}

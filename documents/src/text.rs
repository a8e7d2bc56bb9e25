//! Text files from instruments and spreadsheets in any of the usual encodings: UTF-8, UTF-16 ("Unicode text" of Excel)
//! and Windows-1252.
//!
//! No crate is needed: the standard library decodes UTF-16, and Windows-1252 differs from Latin-1 in only 27
//! characters. A file in another code page (DOS, Mac OS Roman) is decoded as Windows-1252, which preserves its numbers
//! and English labels.

use std::borrow::Cow;

/// Characters 0x80 to 0x9f of Windows-1252; unused ones map to the control characters of Latin-1.
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}', '\u{90}', '‘', '’',
    '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

/// Number of leading bytes that decide whether a file without a byte order mark is UTF-16.
const PROBE: usize = 256;

/// Byte orders of UTF-16.
#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

/// Converts UTF-16 to UTF-8 and removes a byte order mark; returns any other file unchanged.
///
/// Binary parts of a file are left unchanged.
pub fn utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    if let Some(rest) = bytes.strip_prefix(b"\xef\xbb\xbf") {
        return Cow::Borrowed(rest);
    }
    let (order, rest) = if let Some(rest) = bytes.strip_prefix(b"\xff\xfe") {
        (Order::Little, rest)
    } else if let Some(rest) = bytes.strip_prefix(b"\xfe\xff") {
        (Order::Big, rest)
    } else if let Some(order) = unmarked(bytes) {
        (order, bytes)
    } else {
        return Cow::Borrowed(bytes);
    };
    let units = rest.chunks_exact(2).map(|pair| match order {
        Order::Little => u16::from_le_bytes([pair[0], pair[1]]),
        Order::Big => u16::from_be_bytes([pair[0], pair[1]]),
    });
    let text: String = char::decode_utf16(units)
        .map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect();
    Cow::Owned(text.into_bytes())
}

/// The byte order of UTF-16 without a mark, detected by the zero in every other byte of ASCII text.
fn unmarked(bytes: &[u8]) -> Option<Order> {
    let pairs = || bytes[..bytes.len().min(PROBE)].chunks_exact(2);
    if pairs().len() < 2 {
        return None;
    }
    let plain = |byte: u8| matches!(byte, b'\t' | b'\r' | b'\n' | b' '..=b'~');
    if pairs().all(|pair| plain(pair[0]) && pair[1] == 0) {
        Some(Order::Little)
    } else if pairs().all(|pair| pair[0] == 0 && plain(pair[1])) {
        Some(Order::Big)
    } else {
        None
    }
}

/// Decodes a text as UTF-8 if valid, else as Windows-1252.
pub fn characters(bytes: &[u8]) -> Cow<'_, str> {
    let letter = |byte: &u8| match byte {
        0x80..=0x9f => WINDOWS_1252[usize::from(byte - 0x80)],
        byte => char::from(*byte),
    };
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(letter).collect()),
    }
}

/// Decodes a text file in UTF-8, UTF-16 or Windows-1252 and removes its byte order mark. None for binary files, which
/// contain bytes that do not occur in text.
pub fn decode(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let text = match utf8(bytes) {
        Cow::Borrowed(bytes) => characters(bytes),
        Cow::Owned(bytes) => Cow::Owned(characters(&bytes).into_owned()),
    };
    // DOS text may end with Ctrl-Z (0x1a).
    let foreign = |byte: u8| byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x1a | 0x1b);
    (!text.bytes().any(foreign)).then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Zeit;Größe [m/s²]\r\n0,5;–1 €\r\n";

    #[test]
    fn one_text_is_the_same_in_all_encodings() {
        let utf16 = |order: fn(u16) -> [u8; 2]| TEXT.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        let one_byte = |letter: char| match WINDOWS_1252.iter().position(|own| *own == letter) {
            Some(place) => 0x80 + place as u8,
            None => letter as u8,
        };
        for bytes in [
            TEXT.as_bytes().to_vec(),
            [&b"\xef\xbb\xbf"[..], TEXT.as_bytes()].concat(),
            [&b"\xff\xfe"[..], &utf16(u16::to_le_bytes)].concat(),
            [&b"\xfe\xff"[..], &utf16(u16::to_be_bytes)].concat(),
            TEXT.chars().map(one_byte).collect(),
        ] {
            assert_eq!(decode(&bytes).as_deref(), Some(TEXT), "{bytes:x?}");
        }
    }

    #[test]
    fn utf_16_without_a_mark_is_recognised() {
        let text = "t;N [g]\n0;1\n";
        for order in [u16::to_le_bytes, u16::to_be_bytes] {
            let bytes: Vec<u8> = text.encode_utf16().flat_map(order).collect();
            assert_eq!(decode(&bytes).as_deref(), Some(text));
        }
    }

    #[test]
    fn binary_files_are_no_text() {
        for bytes in [
            &b"caff\x00\x01\x00\x00desc"[..],
            b"\x00\x00\x00\x00",
            b"abc\x07",
            b"\x89PNG\r\n\x1a\n\x00",
        ] {
            assert_eq!(decode(bytes), None);
        }
    }
}

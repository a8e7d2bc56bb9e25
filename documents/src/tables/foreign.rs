//! Recognises other file formats by their first bytes, so that an error names the format instead of showing raw bytes.

/// A format that this program does not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Foreign {
    /// The name of the format.
    pub name: &'static str,
    /// How to convert a file to a format that can be read.
    pub remedy: &'static str,
}

const SOUND: &str = "convert it to WAV, as `ffmpeg -i IN -c:a pcm_s24le OUT.wav` does (pcm_f32le for floats)";
const EXPORT: &str =
    "export the recording as WAV, as a universal file with datasets 58, or as a table (CSV) with a column of times";
const TABLE: &str = "save the sheet as CSV";

/// Signatures: offset, bytes, format, remedy.
const SIGNATURES: &[(usize, &[u8], &str, &str)] = &[
    (
        0,
        b"RIFX",
        "a RIFX file, WAV with the most significant byte first",
        SOUND,
    ),
    (0, b"FFIR", "a byte-swapped RIFF file", SOUND),
    (
        0,
        b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb",
        "a W64 file (Sony Wave64)",
        SOUND,
    ),
    (8, b"AIFF", "an AIFF file", SOUND),
    (8, b"AIFC", "an AIFF-C file", SOUND),
    (0, b"fLaC", "a FLAC file", SOUND),
    (0, b"caff", "a CAF file (Apple Core Audio Format)", SOUND),
    (0, b"OggS", "an Ogg file", SOUND),
    (0, b".snd", "an AU file (Sun, NeXT)", SOUND),
    (0, b"dns.", "an AU file (DEC)", SOUND),
    (0, b"ID3", "an MP3 file", SOUND),
    (0, b"\xff\xfb", "an MP3 file", SOUND),
    (0, b"\xff\xf3", "an MP3 file", SOUND),
    (4, b"ftyp", "an MP4 or QuickTime file", SOUND),
    (0, b"\x1a\x45\xdf\xa3", "a Matroska file", SOUND),
    (0, b"\x30\x26\xb2\x75\x8e\x66\xcf\x11", "a Windows Media file", SOUND),
    (0, b"wvpk", "a WavPack file", SOUND),
    (0, b"MAC ", "a Monkey's Audio file", SOUND),
    (0, b"NIST_1A", "a SPHERE file (NIST)", SOUND),
    (0, b"Creative Voice File", "a VOC file", SOUND),
    (0, b"2BIT", "an AVR file", SOUND),
    (0, b"MATLAB 5.0 MAT-file", "a MAT-file of MATLAB", EXPORT),
    (0, b"MATLAB 7.3 MAT-file", "a MAT-file of MATLAB", EXPORT),
    (0, b"\x89HDF\r\n\x1a\n", "an HDF5 file", EXPORT),
    (0, b"TDSm", "a TDMS file of LabVIEW", EXPORT),
    (0, b"MDF     ", "an MDF file (ASAM)", EXPORT),
    (0, b"HEAD acoustics", "an HDF file of HEAD acoustics", EXPORT),
    (
        0,
        b"PK\x03\x04",
        "a ZIP archive, as XLSX, ODS and ATFX files are",
        TABLE,
    ),
    (
        0,
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "an old Excel or other OLE file",
        TABLE,
    ),
    (0, b"\x1f\x8b", "a gzip archive", "unpack it"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it"),
    (0, b"%PDF", "a PDF file", EXPORT),
    (0, b"\x89PNG", "a PNG picture", EXPORT),
    (0, b"\x7fELF", "a program", EXPORT),
    (0, b"SQLite format 3", "an SQLite database", EXPORT),
    (0, b"<?xml", "an XML file", EXPORT),
    (0, b"<html", "a page of HTML", EXPORT),
    (0, b"<!DOCTYPE html", "a page of HTML", EXPORT),
    (
        0,
        b"version https://git-lfs",
        "a pointer of Git LFS, not the file itself",
        "fetch it with `git lfs pull`",
    ),
];

/// Recognises the format of a file that cannot be read; none if it is unknown.
pub fn foreign(bytes: &[u8]) -> Option<Foreign> {
    let form = |at: usize| bytes.get(at..at + 4);
    if bytes.starts_with(b"FORM") && !matches!(form(8), Some(b"AIFF" | b"AIFC")) {
        return Some(Foreign {
            name: "an IFF file without AIFF sound",
            remedy: SOUND,
        });
    }
    SIGNATURES
        .iter()
        .find(|(at, signature, ..)| bytes.get(*at..).is_some_and(|rest| rest.starts_with(signature)))
        .filter(|(at, ..)| *at != 8 || bytes.starts_with(b"FORM"))
        .map(|&(_, _, name, remedy)| Foreign { name, remedy })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn containers_are_named_for_what_they_are() {
        for (bytes, word) in [
            (&b"RIFX\0\0\0\x24WAVEfmt "[..], "RIFX"),
            (b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\0\0", "W64"),
            (b"FORM\0\0\0\x24AIFFCOMM", "AIFF"),
            (b"FORM\0\0\0\x24AIFCFVER", "AIFF-C"),
            (b"fLaC\0\0\0\x22", "FLAC"),
            (b"caff\0\x01\0\0desc", "CAF"),
            (b"OggS\0\x02", "Ogg"),
            (b"ID3\x04\0", "MP3"),
            (b"PK\x03\x04\x14\0", "XLSX"),
            (b"\x89HDF\r\n\x1a\n", "HDF5"),
        ] {
            let found = foreign(bytes).map(|own| own.name);
            assert!(found.is_some_and(|name| name.contains(word)), "{word}: {found:?}");
        }
        for text in [&b"t,N [g]\n0,1\n"[..], b"", b"RIFF\0\0\0\0WAVE", b"    -1\n    58\n"] {
            assert_eq!(foreign(text), None);
        }
    }
}

"""Has the program read recordings as other programs read them: WAV, universal files and tables in the forms of the field.

    recordings.py NAILNOISE

Makes some 90 files: WAV of all formats of samples, containers, lengths of headers and orders of chunks; universal files (58, 58b)
of both byte orders, single and double precision, even and uneven times, together with complex datasets; tables in
encodings, separators, decimal marks and rows of units. Each is a channel of one manifest. RMS and peak in
`measurement.json` of `nailnoise measure` must agree with those of the samples that soundfile and scipy, pyuff, and
Python's csv read from the same file; where none of them reads a file, with its original samples, and the script names
these files. `prf fit` must find one law in all forms of a recording. Files of other formats must end with status 2, be
named by their format, and put no control characters on a terminal.

Needs numpy, scipy, soundfile, pyuff. Takes some seconds.
"""

import csv
import io
import json
import os
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pyuff
import scipy.io
import scipy.io.wavfile
import soundfile

warnings.simplefilter("ignore")
RATE = 48_000
GRAVITY = 9.80665
FULL_SCALE = 1000.0  # m/s2
PCM, FLOAT, ALAW, MULAW, ADPCM, EXTENSIBLE = 1, 3, 6, 7, 2, 0xFFFE
GUID = bytes.fromhex("000000001000800000aa00389b71")

# A burst whose peak, sign and RMS change if samples are shifted, swapped, scaled or read from the wrong end.
t = np.arange(RATE) / RATE
SIGNAL = 0.25 * np.exp(-t / 0.2) * np.sin(2 * np.pi * (300 + 900 * t) * t) + 0.001 * np.sin(2 * np.pi * 5000 * t)


# --- Files ---------------------------------------------------------------------------------------------------------


def chunk(name, content, pad=True):
    return name + struct.pack("<I", len(content)) + content + b"\0" * (pad and len(content) % 2)


def header(tag, channels, bits, container, length=16, valid=None):
    """A `fmt ` chunk of 16, 18, 40 bytes, or extensible (40) and extensible with two bytes more (42)."""
    block = channels * container
    extensible = length >= 40 and valid is not None
    fields = (EXTENSIBLE if extensible else tag, channels, RATE, RATE * block, block, bits)
    content = struct.pack("<HHIIHH", *fields)
    if extensible:
        content += struct.pack("<HHIH", length - 18, valid, 0, tag) + GUID
    elif length > 16:
        content += struct.pack("<H", length - 18)
    return chunk(b"fmt ", content.ljust(length, b"\0"))


def integers(signal, valid, container):
    """Samples whose valid bits are the highest ones of their container (Microsoft, WAVEFORMATEXTENSIBLE)."""
    whole = np.round(signal * (2 ** (valid - 1) - 1)).astype(object)
    if container == 1:
        return bytes(int(x) + 128 for x in whole)
    return b"".join((int(x) << (8 * container - valid)).to_bytes(container, "little", signed=True) for x in whole)


def riff(*chunks, mark=b"RIFF"):
    body = b"WAVE" + b"".join(chunks)
    return mark + struct.pack("<I", len(body)) + body


def rf64(data, *chunks, mark=b"RF64"):
    ds64 = lambda length: chunk(b"ds64", struct.pack("<QQQI", length, len(data), RATE, 0))
    body = lambda length: b"WAVE" + ds64(length) + b"".join(chunks) + b"data" + b"\xff" * 4 + data
    return mark + b"\xff" * 4 + body(len(body(0)))


def wav_files():
    """Name, bytes, valid bits (none for floats)."""
    forms = {
        "u8": (PCM, 8, 1, integers(SIGNAL, 8, 1)),
        "s16": (PCM, 16, 2, integers(SIGNAL, 16, 2)),
        "s24": (PCM, 24, 3, integers(SIGNAL, 24, 3)),
        "s32": (PCM, 32, 4, integers(SIGNAL, 32, 4)),
        "f32": (FLOAT, 32, 4, SIGNAL.astype("<f4").tobytes()),
        "f64": (FLOAT, 64, 8, SIGNAL.astype("<f8").tobytes()),
    }
    odd = chunk(b"iXML", b"<BWFXML/>")
    for name, (tag, bits, width, samples) in forms.items():
        valid = bits if tag == PCM else None
        data, fact = chunk(b"data", samples), chunk(b"fact", struct.pack("<I", RATE))
        yield f"{name}-plain", riff(header(tag, 1, bits, width), data), valid
        yield f"{name}-18", riff(header(tag, 1, bits, width, 18), fact, odd, data, chunk(b"LIST", b"INFO")), valid
        yield f"{name}-40", riff(chunk(b"JUNK", b"\0" * 27), header(tag, 1, bits, width, 40), data), valid
        yield f"{name}-extensible", riff(chunk(b"bext", b"x" * 603), header(tag, 1, bits, width, 40, bits), data), valid
        yield f"{name}-rf64", rf64(samples, header(tag, 1, bits, width, 40, bits), odd), valid
    for valid, container in ((24, 4), (16, 4), (16, 3), (20, 3), (12, 2), (20, 4)):
        data = chunk(b"data", integers(SIGNAL, valid, container))
        yield f"{valid}-in-{8 * container}", riff(header(PCM, 1, 8 * container, container, 40, valid), data), valid
    data = chunk(b"data", integers(SIGNAL, 24, 4))
    yield "24-in-32-plain", riff(header(PCM, 1, 24, 4), data), 24
    tag, bits, width, samples = forms["s16"]
    plain, data = header(tag, 1, bits, width), chunk(b"data", samples)
    yield "s16-cb24", riff(header(tag, 1, bits, width, 42, 16), data), 16
    yield "s16-fact8", riff(plain, chunk(b"fact", struct.pack("<II", RATE, 7)), data), 16
    yield "s16-format-behind", riff(data, plain), 16
    yield "s16-no-pad", riff(plain, chunk(b"iXML", b"<a/>!", pad=False), data), 16
    yield "s16-byte-more", riff(plain, chunk(b"data", samples + b"\7")), 16
    yield "s16-open", riff(plain, b"data" + b"\xff" * 4 + samples), 16
    yield "s16-rest", riff(plain, data) + b"rest", 16
    yield "s16-bw64", rf64(samples, plain, mark=b"BW64"), 16
    nine = np.stack([np.roll(SIGNAL, 0) * (1 if k == 4 else 0.1 * k) for k in range(9)], axis=1).reshape(-1)
    yield "s24-nine", riff(header(PCM, 9, 24, 3, 40, 24), chunk(b"data", integers(nine, 24, 3))), 24


def set58(data, spacing, order=None, unit="m/s2", second="s", kind=1, title="burst", times="f4"):
    """A dataset 58 of the signal: data type 2 or 4 real, 5 or 6 complex; spacing 1 even, 0 uneven; order none is text.

    The binary times of uneven samples are in single precision (f4), or, as pyuff has them, in that of the samples (f8).
    """
    double, even = data in (4, 6), spacing == 1
    y = SIGNAL if data < 5 else np.stack([SIGNAL[:64], SIGNAL[:64]], axis=1).reshape(-1)
    n = len(SIGNAL) if data < 5 else 64
    x = np.arange(n) / RATE
    none = f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}"
    lines = [title, "NONE", "NONE", "NONE", "NONE"]
    lines += [f"{kind:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{1:10d}{3:4d} {'NONE':<10}{0:10d}{0:4d}"]
    lines += [f"{data:10d}{n:10d}{spacing:10d}{0:13.5E}{1 / RATE if even else 0:13.5E}{0:13.5E}"]
    abscissa = (17, "time", second) if kind == 1 else (18, "frequency", "Hz")
    lines += [f"{abscissa[0]:10d}{0:5d}{0:5d}{0:5d} {abscissa[1]:<20} {abscissa[2]:<20}"]
    lines += [f"{12:10d}{0:5d}{0:5d}{0:5d} {'acceleration':<20} {unit:<20}", none, none]
    encoded = "\n".join(lines).encode("latin-1") + b"\n"
    if order is None:
        if even:
            each = 4 if double else 6
            word = "{:20.11E}" if double else "{:13.5E}"
            rows = ["".join(word.format(v) for v in y[k : k + each]) for k in range(0, len(y), each)]
        else:
            word = "{:13.5E}{:20.11E}" if double else "{:13.5E}{:13.5E}"
            each = 2 if double else 3
            pairs = [word.format(a, b) for a, b in zip(x, y)]
            rows = ["".join(pairs[k : k + each]) for k in range(0, n, each)]
        return b"    -1\n    58\n" + encoded + "\n".join(rows).encode() + b"\n    -1\n"
    mark, number = ("<", 1) if order == "little" else (">", 2)
    values = y.astype(f"{mark}f{8 if double else 4}")
    if not even:
        pair = np.dtype([("x", f"{mark}{times}"), ("y", values.dtype)])
        values = np.array(list(zip(x, y)), dtype=pair)
    head = f"    -1\n    58b{number:6d}{2:6d}{11:12d}{values.nbytes:12d}{0:6d}{0:6d}{0:12d}{0:12d}\n"
    return head.encode() + encoded + values.tobytes() + b"\n    -1\n"


def universal_files():
    """Name, bytes, which dataset 58 from 1."""
    for data, precision in ((2, "single"), (4, "double")):
        for spacing, times in ((1, "even"), (0, "uneven")):
            for order in (None, "little", "big"):
                yield f"58-{precision}-{times}-{order or 'text'}", set58(data, spacing, order), 1
    for order in ("little", "big"):
        yield f"58-double-uneven-{order}-double-times", set58(4, 0, order, times="f8"), 1
    frf = set58(5, 1, kind=4)
    binary_frf = set58(6, 1, "big", kind=4)
    other = b"    -1\n   151\nmodel\n    -1\n    -1\n  1858\nqualifiers\n    -1\n"
    yield "58-behind-frf", frf + set58(4, 1), 2
    yield "58b-behind-frf", binary_frf + frf + set58(2, 1, "little"), 3
    yield "58-behind-others", other + set58(4, 1), 1
    yield "58-latin-1", set58(4, 1, unit="m/s\u00b2", title="Pr\u00fcfung"), 1
    yield "58-sec", set58(4, 1, second="sec"), 1
    yield "58-bom", b"\xef\xbb\xbf" + set58(4, 1), 1


def table(separator=",", decimal=".", units="heading", quote=False, preamble="", end="\n", time_name="Time"):
    number = lambda x, digits: f"{x:.{digits}e}".replace(".", decimal)
    rows = [[number(k / RATE, 9), number(FULL_SCALE * v, 9)] for k, v in enumerate(SIGNAL)]
    heads = {
        "heading": [[f"{time_name} [sec]", "\u00e4 [m/s\u00b2]"]],
        "row": [[time_name, "\u00e4"], ["(s)", "(m/s\u00b2)"]],
        "bare row": [[time_name, "\u00e4"], ["s", "m/s2"]],
        "slash": [[f"{time_name} / s", "\u00e4 / (m/s\u00b2)"]],
    }[units]
    mark = '"' if quote else ""
    return preamble + end.join(separator.join(f"{mark}{cell}{mark}" for cell in row) for row in heads + rows) + end


def table_files():
    """Name, bytes, separator, decimal mark, encoding, lines before the numbers."""
    encodings = {"utf8": "utf-8", "bom": "utf-8-sig", "utf16le": "utf-16-le", "utf16be": "utf-16-be", "cp1252": "cp1252"}
    for name, encoding in encodings.items():
        for separator, decimal in ((",", "."), (";", ","), ("\t", ",")):
            text = ("\ufeff" if encoding.startswith("utf-16") else "") + table(separator, decimal)
            place = {",": "comma", ";": "semicolon", "\t": "tab"}[separator]
            yield f"table-{name}-{place}", text.encode(encoding), separator, decimal, encoding, 1
    forms = {
        "row": (dict(units="row"), 2),
        "bare-row": (dict(units="bare row", separator=";", decimal=","), 2),
        "slash": (dict(units="slash", separator="\t"), 1),
        "quoted": (dict(quote=True), 1),
        "quoted-comma": (dict(quote=True, decimal=","), 1),
        "preamble": (dict(preamble="Model;DSO 123\nDate;2024-01-01\n\n", separator=";"), 4),
        "crlf": (dict(end="\r\n", separator=";", decimal=","), 1),
        "zeit": (dict(time_name="Zeit", separator=";", decimal=","), 1),
        "sep": (dict(preamble="sep=;\n", separator=";"), 2),
    }
    for name, (form, lines) in forms.items():
        yield f"table-{name}", table(**form).encode(), form.get("separator", ","), form.get("decimal", "."), "utf-8", lines


# --- Readings by other programs --------------------------------------------------------------------------------------


def by_soundfile(path, _):
    return soundfile.read(path, always_2d=True)[0]


def by_scipy(path, valid):
    samples = scipy.io.wavfile.read(path)[1]
    samples = samples.reshape(len(samples), -1)
    if samples.dtype == np.uint8:
        return (samples.astype(float) - 128) / 128
    if samples.dtype.kind == "i":
        return samples / 2.0 ** (8 * samples.dtype.itemsize - 1)
    return samples.astype(float)


def by_pyuff(path, channel):
    found = pyuff.UFF(str(path)).read_sets()
    found = [one for one in (found if isinstance(found, list) else [found]) if one["type"] == 58]
    return np.asarray(found[channel - 1]["data"], dtype=float)


def by_csv(data, separator, decimal, encoding, lines):
    text = data.decode(encoding).lstrip("\ufeff")
    rows = [row for row in csv.reader(io.StringIO(text), delimiter=separator)][lines:]
    return np.array([float(row[1].replace(decimal, ".")) for row in rows if row])


def rms_and_peak(samples):
    """[g] over the second of `measure`: without the mean, with half-cosine ends of 5 ms."""
    x = samples - np.mean(samples)
    count = round(5e-3 * RATE)
    rise = 0.5 * (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count))
    x[:count] *= rise
    x[-count:] *= rise[::-1]
    return np.sqrt(np.mean(x * x)) / GRAVITY, np.max(np.abs(x)) / GRAVITY


# --- Runs ------------------------------------------------------------------------------------------------------------


def run(program, folder, *arguments):
    return subprocess.run([program, *arguments], cwd=folder, capture_output=True, timeout=100)


def measured(program, folder, channels):
    """RMS and peak [g] of channels, given as text of the manifest."""
    (folder / "mic.wav").write_bytes(riff(header(PCM, 1, 16, 2), chunk(b"data", integers(SIGNAL, 16, 2))))
    lines = ['setup = "worktable"', "centre = [0, 0, 0.938]", 'plane = "floor"', 'temperature = "21 degC"', "[channels]"]
    lines += ['mic1 = { file = "mic.wav", full_scale = "100 Pa", position = [1, 1, 1.938] }', *channels]
    lines += ["[configurations]", 'W-1 = { repeats = 1, trigger = "10 ms" }']
    (folder / "m.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    done = run(program, folder, "measure", "m.toml", "--out", "out", "--quiet")
    if done.returncode:
        return done, {}
    (configuration,) = json.loads((folder / "out/measurement.json").read_text())["configurations"]
    return done, {own["name"]: (own["rms_g"], own["peak_g"]) for own in configuration["accelerations"]}


def compare(name, found, expected, tolerance):
    for what, a, b in zip(("RMS", "peak"), found, expected):
        assert abs(a / b - 1) < tolerance, f"{name}: {what} {a} g, expected {b} g"


def check_channels(program, folder):
    channels, expected, alone = [], {}, []
    for name, data, valid in wav_files():
        path = folder / f"{name}.wav"
        path.write_bytes(data)
        channel = 5 if name == "s24-nine" else 1
        channels.append(f'{name} = {{ file = "{path.name}", channel = {channel}, full_scale = "{FULL_SCALE} m/s2" }}')
        # Full scale is the largest integer here, but 2^(bits - 1) in the other readers.
        scale = FULL_SCALE * (2 ** (valid - 1) / (2 ** (valid - 1) - 1) if valid else 1)
        read = []
        for reader in (by_soundfile, by_scipy):
            try:
                samples = reader(path, valid)[:, channel - 1]
            except Exception:
                continue
            if len(samples) >= RATE:  # others may read bytes after an open length as samples
                read.append(scale * samples[:RATE])
        if not read:
            alone.append(name)
            read = [FULL_SCALE * SIGNAL]
        half_step = 0.6 * FULL_SCALE / 2 ** ((valid or 30) - 1)
        expected[name] = (read, max(1e-5, half_step / (0.25 * FULL_SCALE)) if name in alone else 1e-5)
    for name, data, channel in universal_files():
        path = folder / f"{name}.uff"
        path.write_bytes(data)
        channels.append(f'{name} = {{ file = "{path.name}", channel = {channel} }}')
        try:
            read = by_pyuff(path, channel)
            # pyuff reads the times of double samples as double, too.
            assert len(read) == RATE and name not in ("58-double-uneven-little", "58-double-uneven-big")
        except Exception:
            read, _ = SIGNAL, alone.append(name)
        expected[name] = ([read], 1e-5)
    for name, data, *form in table_files():
        path = folder / f"{name}.csv"
        path.write_bytes(data)
        channels.append(f'{name} = {{ file = "{path.name}", column = "\u00e4" }}')
        expected[name] = ([by_csv(data, *form)], 1e-6)
    done, found = measured(program, folder, channels)
    assert done.returncode == 0, done.stderr.decode()
    assert set(found) == set(expected), set(expected) ^ set(found)
    for name, (all_read, tolerance) in expected.items():
        for read in all_read:
            compare(name, found[name], rms_and_peak(np.array(read, dtype=float)), tolerance)
    return len(found), alone


def check_fits(program, folder, machine):
    """One recording of a drive in many forms gives one law."""
    done = run(program, folder, "prf", "machine", machine, "--virtual", "7", "--out", "m", "--quiet")
    assert done.returncode == 0, done.stderr.decode()
    rows = list(csv.reader((folder / "m/drive-1-1.csv").open()))
    text, drives = (folder / "m/drive-1-1.csv").read_text(), (folder / "m/drives.csv").read_text()
    german = "\r\n".join(";".join(cell.replace(".", ",") for cell in row) for row in rows)
    milli = "\n".join(
        ["Time [ms],Depth [mm],Force [kN]"]
        + [",".join(repr(float(v) * f) for v, f in zip(row, (1e3, 1e3, 1e-3))) for row in rows[1:]]
    )
    forms = {
        "quoted.csv": "\n".join(",".join(f'"{cell}"' for cell in row) for row in rows).encode(),
        "german.csv": german.encode("cp1252"),
        "utf16.csv": ("\ufeff" + text).encode("utf-16-le"),
        "latin1.csv": b"# Pr\xfcfung\n" + text.encode(),
        "bom.csv": text.encode("utf-8-sig"),
        "tabs.csv": text.replace(",", "\t").encode(),
        "milli.csv": milli.encode(),
    }
    lists = {"drives-german.csv": drives.replace(",", ";").encode("utf-16"), "drives-bom.csv": drives.encode("utf-8-sig")}

    def law(name):
        done = run(program, folder, "prf", "fit", f"m/{name}", "--form", "poly(x,5)", "--out", "fit", "--quiet")
        assert done.returncode == 0, f"{name}: {done.stderr.decode()}"
        fit = tomllib.loads((folder / "fit/fit.toml").read_text())
        return [term["coefficient"] for term in fit["terms"]]

    reference = law("drives.csv")
    for name, data in {**forms, **lists}.items():
        if name in forms:
            (folder / "m" / name).write_bytes(data)
            (folder / "m/d.csv").write_text(drives.replace("drive-1-1.csv", name))
        else:
            (folder / "m/d.csv").write_bytes(data)
        for a, b in zip(law("d.csv"), reference, strict=True):
            assert abs(a - b) < 1e-9 * max(map(abs, reference)), f"{name}: {a} for {b}"
    return len(forms) + len(lists)


def check_refusals(program, folder):
    """Other formats end with status 2 and their names."""
    def sound(kind, subtype, **more):
        file = io.BytesIO()
        soundfile.write(file, SIGNAL, RATE, format=kind, subtype=subtype, **more)
        return file.getvalue()

    mat, archive = io.BytesIO(), io.BytesIO()
    scipy.io.savemat(mat, {"x": SIGNAL[:100]})
    with zipfile.ZipFile(archive, "w") as made:
        made.writestr("xl/workbook.xml", "<workbook/>")
    cases = {
        "RIFX": sound("WAV", "PCM_16", endian="BIG"),
        "W64": sound("W64", "PCM_16"),
        "AIFF": sound("AIFF", "PCM_16"),
        "AIFF-C": sound("AIFF", "FLOAT"),
        "FLAC": sound("FLAC", "PCM_16"),
        "CAF": sound("CAF", "PCM_16"),
        "AU file": sound("AU", "PCM_16"),
        "Ogg": sound("OGG", "VORBIS"),
        "A-law": sound("WAV", "ALAW"),
        "mu-law": sound("WAV", "ULAW"),
        "ADPCM": sound("WAV", "MS_ADPCM"),
        "MATLAB": mat.getvalue(),
        "XLSX": archive.getvalue(),
        "binary file": bytes(range(256)) * 10,
        "complex": set58(5, 1),
        "frequency": set58(4, 1, kind=4),
    }
    for words, data in cases.items():
        (folder / "other.bin").write_bytes(data)
        key = "channel = 1"
        done, _ = measured(program, folder, [f'N = {{ file = "other.bin", {key}, full_scale = "1000 m/s2" }}'])
        said = " ".join(done.stderr.decode().replace("|", " ").split())
        assert done.returncode == 2, f"{words}: status {done.returncode}"
        assert words in said and "help:" in said, f"{words} is not in: {said}"
        assert not any(ord(letter) < 32 and letter not in "\n\t" for letter in done.stderr.decode()), f"{words}: {said!r}"
    return len(cases)


def main():
    program = str(Path(sys.argv[1]).resolve())
    machine = str(Path(__file__).parents[2] / "examples/penetration/machine.toml")
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        os.environ["NAILNOISE_CACHE"] = f"{name}/cache"
        folder = Path(name)
        channels, alone = check_channels(program, folder)
        fits = check_fits(program, folder, machine)
        refused = check_refusals(program, folder)
    print(f"recordings: {channels} files read as others read them, {fits} forms of a drive fitted alike, {refused} refused by name")
    print(f"  compared with their samples, because no other program reads them: {', '.join(alone) or 'none'}")
    print(f"  {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()

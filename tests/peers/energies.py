"""Compares the levels of `measure` from a virtual wrapping test with the recorded and with the exact energies.

    energies.py NAILNOISE DESIGN

Perfect wraps: each band of a source that lies 10 dB above the residual, against the source of the recorded shots, bare. The limit is
0.1 dB. The design's wraps: each level against the exact energies, without scatter of the shots and with it, next to the
standard error of the repeats.
"""

import json
import subprocess
import sys
import tempfile

ABOVE = 10.0
LIMIT = 0.1
STILL = ["--set", "test.pressure_scatter=0", "--set", "test.resistance_scatter=0"]


def value(program, *arguments):
    done = subprocess.run([program, *arguments, "--json", "--quiet"], capture_output=True, text=True)
    # Status 3 is a failed check of a valid result.
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


def tested(program, design, *options):
    """A virtual test and its measured levels."""
    with tempfile.TemporaryDirectory() as folder:
        test = value(program, "test", design, *options, "--out", folder)
        return test, value(program, "measure", f"{folder}/manifest.toml", "--out", f"{folder}/measured")


def bands(test, measured):
    """Source, frequency, and measured less recorded level, where the source lies above the residual."""
    for source in test["recorded"]:
        (found,) = [own["bands"] for own in measured["sources"] if own["source"] == source["source"]]
        for own, other, exact in zip(source["bands"], found, test["exact"]["bands"], strict=True):
            residual = exact["configurations_db"][1]
            if None not in (own["lwa_db"], other["lwa_db"]) and (residual is None or own["lwa_db"] > residual + ABOVE):
                yield source["source"], own["hz"], other["lwa_db"] - own["lwa_db"]


def levels(test, measured):
    """Level in energies, and as measured with its standard error, of each source and the bound."""
    exact = test["exact"]
    for place, source in enumerate(test["recorded"]):
        (own,) = [own for own in measured["sources"] if own["source"] == source["source"]]
        yield own["source"], exact["separated_db"][place], own["level"]
    yield "bound", exact["bound_db"], measured["bound"]["level"]


def main(program, design):
    print(f"{design}\nperfect wraps, bands {ABOVE:.0f} dB above the residual")
    found = list(bands(*tested(program, design, "--wraps", "perfect")))
    for name in dict.fromkeys(source for source, _, _ in found):
        own = [(abs(difference), hz) for source, hz, difference in found if source == name]
        print(f"  {name}: {len(own)} bands, at most {max(own)[0]:.3f} dB from the recorded shots, at {max(own)[1]:.0f} Hz")
    for title, scatter in ("without scatter of the shots", STILL), ("with scatter", []):
        print(f"wraps of the design, {title}")
        for name, energies, level in levels(*tested(program, design, *scatter)):
            print(f"  {name}: {energies:.2f} dB in energies, {level['db']:.2f} dB +- {level['standard_db']:.2f} measured")
    sys.exit(any(abs(difference) > LIMIT for _, _, difference in found))


main(*sys.argv[1:])

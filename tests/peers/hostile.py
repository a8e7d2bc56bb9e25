"""Gives the program hostile input and checks status, time and memory of every case.

    hostile.py NAILNOISE DESIGNS [DRAWS] [SEED]

DESIGNS is the folder of the shipped designs. There are five kinds of cases:

- named cases: input that once gave a wrong answer, a hang or a flood, each with its expected status and words;
- whole runs, finished results, names, a full standard output and the cache, on the small design of the tests;
- key cases: every number of the design file, just outside its domain at either end, infinite, not a number, in a unit of
  another dimension; each must end with status 2 and name the key;
- files: devices, pipes, folders, empty, long and binary files instead of designs, bases, meshes and tables;
- draws: designs with ten random keys drawn log-uniformly over their full domains (default 100), in `check` and in
  `cycle`.

Bad input must end with status 2 within 2 s and 1 GiB. A draw must end within 60 s and 4 GiB, without a panic or a signal.
The seconds are those of the processor, so that other work on the machine does not count; ten times as many by the clock
are a hang.
The script prints the counts by status and fails at the end if any case did.
"""

import collections
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

BAD_INPUT = (2.0, 1.0)
DRAW = (60.0, 4.0)


@dataclass
class Outcome:
    """End of one run."""

    status: int
    seconds: float  # of the processor
    elapsed: float  # by the clock
    gigabytes: float
    text: str


@dataclass
class Tally:
    """Cases by kind and status, and those that failed."""

    counts: dict = field(default_factory=lambda: collections.defaultdict(collections.Counter))
    slowest: dict = field(default_factory=dict)
    failures: list = field(default_factory=list)

    def hold(self, kind, name, outcome, statuses, limits, words=()):
        """Counts a case and notes its violations."""
        self.counts[kind][outcome.status] += 1
        if outcome.seconds > self.slowest.get(kind, (0.0, ""))[0]:
            self.slowest[kind] = (outcome.seconds, name)
        seconds, gigabytes = limits
        problems = []
        if outcome.status not in statuses:
            problems.append(f"status {outcome.status}, expected {statuses}")
        if outcome.seconds > seconds:
            problems.append(f"{outcome.seconds:.1f} s, at most {seconds}")
        if outcome.elapsed > 10 * seconds:
            problems.append(f"{outcome.elapsed:.1f} s by the clock")
        if outcome.gigabytes > gigabytes:
            problems.append(f"{outcome.gigabytes:.2f} GiB, at most {gigabytes}")
        if "panicked" in outcome.text:
            problems.append("a panic")
        flat = re.sub(r"\s+", " ", outcome.text)
        problems += [f"no word of {word!r}" for word in words if word not in flat]
        if problems:
            self.failures.append(f"{kind}: {name}: {'; '.join(problems)}\n    {flat[:300]}")


def run(arguments, folder, timeout):
    """Runs a command in a folder; -9 means a timeout."""
    start = time.monotonic()
    with tempfile.TemporaryFile() as out:
        process = subprocess.Popen(arguments, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        status = None
        while status is None:
            pid, code, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                status = os.waitstatus_to_exitcode(code)
            elif time.monotonic() - start > timeout:
                process.kill()
                _, _, usage = os.wait4(process.pid, 0)
                status = -9
            else:
                time.sleep(0.002)
        process.returncode = status
        out.seek(0)
        text = out.read(1 << 20).decode(errors="replace")
    processor = usage.ru_utime + usage.ru_stime
    return Outcome(status, processor, time.monotonic() - start, usage.ru_maxrss / 2**20, text)


def toml(value):
    """A value as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    return repr(value)


class Bench:
    """A folder with designs, and the program."""

    def __init__(self, program, designs, folder):
        self.program, self.designs, self.folder = str(Path(program).resolve()), Path(designs).resolve(), Path(folder)
        os.environ["NAILNOISE_CACHE"] = str(self.folder / "cache")
        self.number = 0

    def design(self, text, base="n80cb.toml"):
        """Writes a design over a shipped one."""
        self.number += 1
        path = self.folder / f"case-{self.number}.toml"
        path.write_text(f"base = {toml(str(self.designs / base))}\n{text}\n")  # an absolute base stays as it is
        return path

    def run(self, *arguments, timeout=620):
        return run([self.program, *map(str, arguments)], self.folder, timeout)


def keys(schema, path=""):
    """Every number of the design file with its domain in SI units: (key, low, high, whole)."""
    for name, node in schema.get("properties", {}).items():
        full = f"{path}{name}"
        plain = next((any_of for any_of in node.get("anyOf", []) if "minimum" in any_of), None)
        if plain is not None:
            yield full, plain["minimum"], plain["maximum"], plain["type"] == "integer"
        elif "properties" in node:
            yield from keys(node, f"{full}.")


# Content of the design, command, expected status, expected words of the message.
NAMED = [
    ('nail.length = "65 mm"\nnail.diameter = "2.9 mm"', ["cycle", "--json"], {3}, ["overdriven", "below the surface"]),
    ('nail.tip_gap = "26 mm"', ["check"], {2}, ["nail.tip_gap", "piston.rod_protrusion"]),
    ('nail.head_gap = "22 mm"', ["check"], {2}, ["nail.head_gap", "nail.feed_height"]),
    ("analysis.workpiece_element = 100", ["run"], {2}, ["analysis.workpiece_element", "100"]),
    ("analysis.mode_margin = 0.1", ["run"], {2}, ["analysis.mode_margin", "0.1"]),
    ("analysis.mode_margin = 1e6", ["run"], {2}, ["analysis.mode_margin"]),
    ("analysis.starts = 1000000", ["run"], {2}, ["analysis.starts", "1000000"]),
    ("analysis.workpiece_max_frequency = 1e7", ["run"], {2}, ["analysis.workpiece_max_frequency"]),
    ('analysis.workpiece_max_frequency = "99 kHz"', ["run"], {2}, ["analysis.workpiece_max_frequency", "GB"]),
    ("wood.elastic.g_rt = 1e30", ["run"], {2}, ["wood.elastic.g_rt"]),
    ("supply.pressure = 1e300", ["run"], {2}, ["supply.pressure"]),
    ("supply.pressure = 1e300", ["cycle"], {2}, ["supply.pressure"]),
    ("model.orifice_linear = 5", ["cycle"], {2}, ["model.orifice_linear"]),
    ("model.friction_velocity = 1e-30", ["cycle"], {2}, ["model.friction_velocity"]),
    ("analysis.duration = 1e6", ["run"], {2}, ["analysis.duration"]),
    ('analysis.time_step = "100 ns"\nanalysis.duration = "60 s"', ["run"], {2}, ["response", "GB", "analysis.time_step"]),
    ('analysis.time_step = "100 ns"\nanalysis.cycle_end = "10 s"', ["cycle"], {2}, ["nailing cycle", "GB"]),
    ('analysis.workpiece_element = "0.1 mm"', ["run"], {2}, ["modes of the workpiece", "GB", "analysis.workpiece_element"]),
    ('analysis.workpiece_element = "0.1 mm"', ["check"], {2}, ["modes of the workpiece", "GB"]),
    ("analysis.worktable_element = 1e-6", ["check"], {2}, ["analysis.worktable_element"]),
    ('analysis.worktable_element = "0.1 mm"', ["check"], {2}, ["modes of the worktable", "GB"]),
    ('analysis.worktable_element = "0.1 mm"', ["mesh", "--body", "worktable"], {2}, ["modes of the worktable", "GB"]),
    ('analysis.body_element = "0.05 mm"', ["run"], {2}, ["modes of the tool", "GB", "analysis.body_element"]),
    ('analysis.body_element = "0.05 mm"', ["modes", "--body", "tool"], {2}, ["modes of the tool", "GB"]),
    ('acoustics.bem_max_frequency = "99 kHz"', ["run"], {2}, ["radiation of the workpiece", "GB", "acoustics.bem_max_frequency"]),
    ('analysis.range_low = "1 kHz"\nanalysis.range_high = "1 kHz"', ["run"], {2}, ["range of the ranking"]),
    ("analysis.cycle_end = 1e-9", ["cycle"], {2}, ["analysis.cycle_end"]),
    ("body.loss_factor = inf", ["run"], {2}, ["body.loss_factor"]),
    ("support.contact.loss_ratio = 1e300", ["run"], {2}, ["support.contact.loss_ratio"]),
    ("exhaust.holes = 4294967295", ["check"], {2}, ["exhaust.holes"]),
    (
        "\n".join(f"[sensors.s{n}]\nbody = 'workpiece'\nx = 0\ny = 0\nz = 0.09525\nalong_x = 0\nalong_y = 0\nalong_z = 1\n"
                  "band_low = 1\nband_high = 10000" for n in range(20_000)),
        ["run"], {2}, ["sensors", "250"],
    ),
]


# Cases that once took minutes: design, command.
SLOW = [
    ('body.sleeve_wall = "172 mm"\nbody.cap_wall = "2 mm"', "check"),
    ('body.sleeve_gap = "282 mm"', "check"),
    ("analysis.worktable_top_layers = 50", "check"),
    ("piston.bore = 35\nhead_valve.exhaust_seat_diameter = 0.0576\nhead_valve.exhaust_angle = 0.0343\n"
     "analysis.cycle_tolerance = 9e-9", "cycle"),
]


def named_cases(bench, tally):
    for text, command in SLOW:
        outcome = bench.run(command, bench.design(text), "--json")
        tally.hold("named", f"{command} {text[:60]}", outcome, {0, 2, 3}, DRAW)
    for text, (command, *options), statuses, words in NAMED:
        outcome = bench.run(command, bench.design(text), *options)
        tally.hold("named", f"{command} {text[:60]}", outcome, statuses, BAD_INPUT, words)
    few = bench.run("run", bench.designs / "n80cb.toml", "--memory", "100MB")
    tally.hold("named", "run --memory 100MB", few, {2}, BAD_INPUT, ["--memory", "GB"])
    unit = bench.run("run", bench.designs / "n80cb.toml", "--memory", "8")
    tally.hold("named", "run --memory 8", unit, {2}, BAD_INPUT, ["unit"])


def whole_cases(bench, tally):
    """Cases of whole runs, finished results, names, outputs and the cache, on the small design of the tests."""
    small = bench.designs.parent / "tests/data/small.toml"
    meshes = bench.designs.parent / "meshes/tests/data"

    def hold(name, arguments, statuses, words, limits=DRAW):
        tally.hold("whole", name, bench.run(*arguments), statuses, limits, words)

    def over(text, name=None):
        design = bench.design(text, base=small)
        return design.rename(bench.folder / name) if name else design

    coarse = over('analysis.workpiece_element = "1 m"')
    hold("elements of 1 m", ["run", coarse, "--quiet"], {3}, ["longest element side of the block"])
    margin = over("analysis.mode_margin = 1.0")
    hold("no margin of modes", ["run", margin, "--quiet"], {3}, ["up to which all modes are known"])
    outside = over('piston.mass = "140 g"')
    hold("a value outside its range", ["run", outside, "--json", "--quiet"], {0, 1, 3}, ["outside its range 0.129"])
    for mesh, words in (("tet10-41-text.msh", ["body"]), ("hex8.msh", ["body"])):
        for command in (["run"], ["check", "--body", "tool"]):
            housing = over(f"body.model = 'elastic'\nbody.mesh = {toml(str(meshes / mesh))}")
            hold(f"{command[0]} a housing from {mesh}", [command[0], housing, *command[1:]], {2}, words, BAD_INPUT)
    tiny = over(f"body.model = 'elastic'\nbody.mesh = {toml(str(meshes / 'tet10-41-text.msh'))}\nbody.mesh_unit = '1 um'")
    hold("a housing read 1000 times too small", ["run", tiny], {2}, ["body.mesh_unit"], BAD_INPUT)
    for name in ("...toml", "..toml"):
        hold(f"a design named {name}", ["cycle", over("", name)], {2}, ["--out"], BAD_INPUT)

    for command in (["schema"], ["completions", "bash"], ["cycle", small, "--json"], ["prf", "law", "--list"], ["check", small]):
        with open("/dev/full", "wb") as full:
            process = subprocess.run([bench.program, *map(str, command)], cwd=bench.folder, stdout=full, stderr=subprocess.PIPE)
        outcome = Outcome(process.returncode, 0.0, 0.0, 0.0, process.stderr.decode())
        tally.hold("whole", f"{command[0]} to a full standard output", outcome, {2}, DRAW, ["output"])

    hold("a run to compare", ["run", small, "--quiet", "--out", "finished"], {0}, [])
    result = json.loads((bench.folder / "finished/result.json").read_text())
    loudest = result["ranking"][0]
    changes = {
        "an empty ranking": {"ranking": []},
        "a total without its sources": {"total": {**result["total"], "lwa_db": loudest["lwa_db"] + 20.0}},
        "an absurd level": {"ranking": [{**loudest, "lwa_db": 1e6}, *result["ranking"][1:]]},
        "a share above 1": {"ranking": [{**loudest, "share": 7.0}, *result["ranking"][1:]]},
    }
    for name, change in changes.items():
        folder = bench.folder / name.replace(" ", "-")
        folder.mkdir()
        (folder / "result.json").write_text(json.dumps({**result, **change}))
        hold(f"compare {name}", ["compare", "finished", folder], {2}, ["result.json"], BAD_INPUT)

    entry = next((bench.folder / "cache").glob("modes*.entry"))
    entry.unlink()
    entry.mkdir()
    hold("a folder in the place of an entry", ["run", small, "--quiet", "--json"], {0}, [])
    hold("cache verify mends it", ["cache", "verify"], {0, 1}, ["folder"])
    hold("cache verify finds nothing", ["cache", "verify"], {0}, [])


def key_cases(bench, tally, numbers):
    for key, low, high, whole in numbers:
        beyond = [high * 10 if high > 0 else 1.0, high * (1 + 1e-6) + 1e-300]
        beyond.append(low / 10 if low > 0 else (low * 10 if low < 0 else -1.0))
        if whole:
            beyond = [0, int(high) + 1, -1, 1.5]
        else:
            beyond += [math.inf, math.nan, "1 apple", True, 1e308]
        for value in beyond:
            outcome = bench.run("check", bench.design(f"{key} = {toml(value)}"))
            tally.hold("keys", f"{key} = {toml(value)}", outcome, {2}, BAD_INPUT, [key])


def file_cases(bench, tally):
    folder = bench.folder
    pipe, empty, binary, long = (folder / name for name in ("pipe.toml", "empty.toml", "binary.toml", "long.toml"))
    os.mkfifo(pipe)
    empty.write_text("")
    binary.write_bytes(bytes(random.randrange(256) for _ in range(4096)))
    long.write_bytes(b"# long\n" * (1 << 20))
    odd = [pipe, Path("/dev/zero"), Path("/dev/null"), Path("/"), empty, binary, long, folder / "none.toml"]
    for path in odd:
        for command in ("check", "cycle", "run"):
            tally.hold("files", f"{command} {path}", bench.run(command, path), {2}, BAD_INPUT)
        base = folder / "based.toml"
        base.write_text(f"base = {toml(str(path))}\n")
        tally.hold("files", f"base {path}", bench.run("check", base), {2}, BAD_INPUT)
        for key in ("body.mesh", "workpiece.mesh", "support.worktable.mesh"):
            design = bench.design(f"{key} = {toml(str(path))}")
            tally.hold("files", f"{key} {path}", bench.run("run", design), {2}, BAD_INPUT)
        shipped = bench.designs / "n80cb.toml"
        table = bench.run("cycle", shipped, "--penetration-table", path)
        tally.hold("files", f"--penetration-table {path}", table, {2}, BAD_INPUT)
        measured = bench.run("modes", shipped, "--body", "workpiece", "--mac", path)
        tally.hold("files", f"--mac {path}", measured, {2}, BAD_INPUT)
        tally.hold("files", f"compare {path}", bench.run("compare", path, path), {2}, BAD_INPUT)
    for name in ("deep", "repeated"):
        path = folder / f"{name}.toml"
        path.write_text("a" + ".a" * 5000 + " = 1\n" if name == "deep" else "[supply]\n" * 1000)
        tally.hold("files", name, bench.run("check", path), {2}, BAD_INPUT)
    nested = folder / "nested.toml"
    nested.write_text("x = " + "[" * 100_000 + "]" * 100_000 + "\n")
    tally.hold("files", "nested", bench.run("check", nested), {2}, BAD_INPUT)
    chain = [folder / f"chain-{n}.toml" for n in range(2000)]
    for own, other in zip(chain, chain[1:]):
        own.write_text(f"base = {toml(other.name)}\n")
    chain[-1].write_text(f"base = {toml(chain[0].name)}\n")
    tally.hold("files", "chain of bases", bench.run("check", chain[0]), {2}, BAD_INPUT)


def drawn(generator, low, high, whole):
    """A value between the ends of a domain, log-uniformly over its magnitudes."""
    if low > 0:
        value = math.exp(generator.uniform(math.log(low), math.log(high)))
    else:
        value = high * 10 ** generator.uniform(-12, 0)
        if low < 0 and generator.random() < 0.5:
            value *= low / high
    return max(1, int(value)) if whole else min(max(value, low), high)


def draw_cases(bench, tally, numbers, draws, seed):
    generator = random.Random(seed)
    outcomes = collections.Counter()
    for number in range(draws):
        chosen = generator.sample(numbers, 10)
        text = "\n".join(f"{key} = {toml(drawn(generator, low, high, whole))}" for key, low, high, whole in chosen)
        design = bench.design(text)
        for command in (["check", design], ["cycle", design, "--json"]):
            outcome = bench.run(*command)
            found = re.search(r'"outcome": "(\w+)"', outcome.text)
            reason = re.search(r"^(\w+::\w+)", outcome.text, re.M)
            outcomes[command[0], outcome.status, (found or reason or ["", "-"])[1]] += 1
            tally.hold("draws", f"{command[0]} {text}", outcome, {0, 2, 3}, DRAW)
    for (command, status, what), count in sorted(outcomes.items(), key=str):
        print(f"  {command:6} status {status:3} {what:30} {count}")


def main():
    program, designs = sys.argv[1:3]
    draws = int(sys.argv[3]) if len(sys.argv) > 3 else 100
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(program, designs, folder)
        schema = json.loads(subprocess.run([bench.program, "schema"], capture_output=True, check=True, text=True).stdout)
        numbers = list(keys(schema))
        assert len(numbers) > 200, f"only {len(numbers)} numbers in the schema"
        named_cases(bench, tally)
        whole_cases(bench, tally)
        key_cases(bench, tally, numbers)
        file_cases(bench, tally)
        draw_cases(bench, tally, numbers, draws, seed)
    for kind, counts in tally.counts.items():
        by_status = ", ".join(f"{count} with status {status}" for status, count in sorted(counts.items()))
        seconds, name = tally.slowest[kind]
        print(f"{kind}: {by_status}; slowest {seconds:.1f} s: {name[:70]!r}")
    for failure in tally.failures:
        print(f"FAILED {failure}")
    total = sum(sum(counts.values()) for counts in tally.counts.values())
    print(f"{total} cases, {len(tally.failures)} failed")
    sys.exit(1 if tally.failures else 0)


if __name__ == "__main__":
    main()

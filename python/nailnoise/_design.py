"""Designs: TOML files with values over them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from typing import Any

from . import _native
from ._tables import table

Value = str | float | int | bool


def _text(value: Value) -> str:
    """A value as it would stand in a design file, a text without quotes."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else repr(value)


def _assignments(values: Mapping[str, Value]) -> list[str]:
    return [f"{key}={_text(value)}" for key, value in values.items()]


def load(path: str | os.PathLike[str], values: Mapping[str, Value] | None = None) -> Design:
    """Reads a design file, with values over it: ``load("n80cb.toml", {"supply.pressure": "80 psig"})``.

    A number without a unit is in the SI unit of its key. Raises NailnoiseError for what is no design, with its place and remedy.
    """
    return Design(_native.Design.load(os.fspath(path), _assignments(values or {})), values)


class Design(Mapping[str, Any]):
    """A design: a mapping from full key names to values in SI units."""

    def __init__(self, native: _native.Design, values: Mapping[str, Value] | None = None) -> None:
        self._native = native
        self._values = dict(values or {})
        self._entries: dict[str, dict[str, Any]] = {entry["key"]: entry for entry in json.loads(native.entries())}

    @property
    def name(self) -> str:
        """Name of the file without its extension."""
        return self._native.name

    @property
    def digest(self) -> str:
        """SHA-256 of every value that results depend on."""
        return self._native.digest

    @property
    def path(self) -> str:
        """The file."""
        return os.fspath(self._native.path)

    @property
    def warnings(self) -> list[str]:
        """What is odd about the values."""
        return self._native.warnings

    def __getitem__(self, key: str) -> Any:
        return self._entries[key]["value"]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def entry(self, key: str) -> dict[str, Any]:
        """A value with its unit, range, provenance, source, file and line."""
        return dict(self._entries[key])

    @property
    def entries(self) -> Any:
        """All of these as a table."""
        return table(list(self._entries.values()), "key")

    @property
    def ranges(self) -> Any:
        """Keys and derived quantities that have a range, in SI units, as a table; ``origin`` says whether a range is assumed."""

        def row(entry: dict[str, Any]) -> dict[str, Any]:
            low, high = entry["range"]
            kept = {name: entry[name] for name in ("key", "value", "unit", "provenance", "source")}
            return {**kept, "low": low, "high": high, "origin": entry["range_origin"]}

        entries = [*self._entries.values(), *json.loads(self._native.drawn_derived())]
        return table([row(entry) for entry in entries if entry["range"]], "key")

    def with_(self, values: Mapping[str, Value] | None = None, /, **more: Value) -> Design:
        """The design with other values: ``design.with_({"exhaust.holes": 18, "exhaust.hole_diameter": "3.15 mm"})``.

        A keyword has two underscores for each full stop of its key: ``design.with_(exhaust__holes=18)``.
        """
        given = {**(values or {}), **{key.replace("__", "."): value for key, value in more.items()}}
        return Design(self._native.with_assignments(_assignments(given)), {**self._values, **given})

    def differences(self, other: Design) -> Any:
        """Keys whose values differ from those of another design, as a table."""
        keys = [*self, *(key for key in other if key not in self._entries)]
        rows = [{"key": key, self.name: self.get(key), other.name: other.get(key)} for key in keys]
        rows = [row for row in rows if self.get(row["key"]) != other.get(row["key"])]
        return table(rows, "key")

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy in another process reads the same file."""
        return load, (os.path.abspath(self.path), self._values)

    def __repr__(self) -> str:
        return f"<nailnoise.Design {self.name!r}: {len(self)} values, {self.digest[:12]}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Design) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

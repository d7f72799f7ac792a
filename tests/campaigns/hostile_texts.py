"""Scenarios and tables of cases, changed by chance and by intent."""

from __future__ import annotations

import hashlib
import json
import random
from pathlib import Path
from typing import Any

import pyarrow
import pyarrow.parquet
from heave_bringup.nodes import NODE_BY_NAME
from heave_bringup.scenarios import shipped_scenarios
from heave_node.parameters import ParameterInfo, describe
from heave_node.scenario import read_sections, sections_text

BOMBS: tuple[bytes, ...] = (
    b"a: &a [x, x, x]\n" + b"".join(b"k%d: &k%d [*a, *a, *a]\n" % (n, n) for n in range(30)),
    b"a: &a " + b"[*a]",
    b"[" * 200_000,
    b"{a: " * 5_000 + b"1" + b"}" * 5_000,
    b"/**: {ros__parameters: {" + b"x" * 1_000_000 + b": 1}}",
    b"/**: {ros__parameters: {seed: " + b"9" * 200_000 + b"}}",
    b"/**: {ros__parameters: {external: [" + b"a, " * 200_000 + b"a]}}",
    b"".join(b"/%s: {ros__parameters: {a: 1}}\n" % (b"**/" * n + b"x") for n in range(60)),
    b"/**: {ros__parameters: {wanted: {" + b", ".join(b"k%d: 1" % n for n in range(30_000)) + b"}}}",
    b"".join(b"n%d: {ros__parameters: {a: 1}}\n" % n for n in range(20_000)),
    b"",
    b"\xef\xbb\xbf",
    b"\xff\xfe/\x00*\x00",
    b"\x00" * 100,
)
"""Files that are small and would be much, or are none."""

VALUES: tuple[str, ...] = (
    *("1:30:00", "9" * 5000, "-1", "0", "1e308", "-1e308", "1e-308", ".nan", ".inf", "-.inf", "1e400", "0x" + "f" * 99),
    *("[]", "{}", "[[[]]]", "{a: {b: {c: 1}}}", "null", "true", "off", "'off'", "''", "'" + "x" * 10_000 + "'", "="),
    *("!!binary aGVhdmU=", "!!set {a}", "!!python/object/apply:os.abort []", "!!timestamp 2001-01-01", "2001-01-01"),
    *("*a", "&a 1", "&a [*a]", "'../../../etc/passwd'", "/dev/zero", "/dev/stdin", "/", "/proc/self/mem", "'a\\0b'"),
    *('"\\x1b[2J"', '"\\ud800"', '"a\\nb"', "9223372036854775808", "1000000000", "123456789012345678901234567890"),
    *("[1, 2, 3]", "[1, a]", "[.nan]", "wire_28mm_6x36", "0.001", "1000", "regular", "spectrum", "file", "mpc", "<<"),
    *("<= 0.005", "'>= nan'", "'<= 1e999'", "'< < 1'", "> 3", "-0.0", "1_000", "0b11", "017"),
)
"""Values that a number, a word or a list is replaced by."""

FRAGMENTS = tuple(text.encode("latin-1") for text in ("\0", "\xff", "\n", "  ", ": ", *"{}[]#'", "&a ", "*a", "- "))
NAMES = ("../../up", "/tmp/heave-hostile", "..", "own.csv", "a/b", "x" * 300, "", 7, None, "a\nb")
SIZES = (-1, 10**12, "1", None, 1.5, True, 3 << 30)


PARAMETRISED = [name for name, node in NODE_BY_NAME.items() if describe(node.parameters_type())]
"""Nodes that have parameters of their own."""


def changed_scenario(chance: random.Random) -> bytes:
    """Return a shipped scenario, changed in one to three places, or one of the BOMBS."""
    if chance.random() < 0.1:
        return chance.choice(BOMBS)
    path = chance.choice(list(shipped_scenarios().values()))
    if chance.random() < 0.6:
        return _with_other_numbers(path, chance)
    content = path.read_bytes()
    for _ in range(chance.randint(1, 3)):
        change = chance.choice((_value_changed, _value_changed, _line_changed, _bytes_changed, _own_section))
        content = change(content, chance)
    return content


def _with_other_numbers(path: Path, chance: random.Random) -> bytes:
    """Return the scenario at `path` with one to four numbers or words that are other ones: the form stays."""
    sections = read_sections(path)
    places = [(section, name) for section, values in sections.items() for name in values]
    for section, name in chance.sample(places, min(len(places), chance.randint(1, 4))):
        value = sections[section][name]
        sections[section][name] = _other(value, chance)
    if chance.random() < 0.5:
        node = chance.choice(PARAMETRISED)
        info = chance.choice(describe(NODE_BY_NAME[node].parameters_type()))
        sections.setdefault(f"/**/{node}", {})[info.name] = _within(info, chance)
    return sections_text(sections).encode("utf-8", "surrogatepass")


def _other(value: object, chance: random.Random) -> object:
    if isinstance(value, list):
        return [_other(one, chance) for one in value] if chance.random() < 0.7 else value * chance.choice((0, 2, 1000))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return chance.choice((not value, "nothing", "", 1, str(value) + "x", [value]))
    factor = chance.choice((-1, 0, 1e-9, 1e-3, 0.1, 0.5, 2, 10, 1e3, 1e9))
    return round(value * factor) if isinstance(value, int) else value * factor


def _within(info: ParameterInfo, chance: random.Random) -> object:
    """Return a value that a parameter allows: the ends of its range, one of its choices."""
    if info.choices or info.type is str:
        one: object = chance.choice(info.choices or ("", "x"))
    elif info.type is bool:
        one = chance.random() < 0.5
    else:
        low = -1e6 if info.minimum is None else info.minimum
        high = 1e6 if info.maximum is None else info.maximum
        one = info.type(chance.choice((low, high, low + 0.5 * (high - low), low + 1e-3 * (high - low))))
    return [one] * (info.length or chance.randint(1, 3)) if info.is_array else one


def _value_changed(content: bytes, chance: random.Random) -> bytes:
    """Replace what stands behind a colon, up to the next comma, bracket or end of the line."""
    places = [place for place in range(len(content)) if content[place : place + 2] == b": "]
    if not places:
        return content
    begin = chance.choice(places) + 2
    end = min((found for mark in b",}\n#" if (found := content.find(bytes([mark]), begin)) >= 0), default=len(content))
    return content[:begin] + chance.choice(VALUES).encode("utf-8", "surrogatepass") + content[end:]


def _line_changed(content: bytes, chance: random.Random) -> bytes:
    """Leave a line out, write it twice, move it in or out, or put it elsewhere."""
    lines = content.split(b"\n")
    place = chance.randrange(len(lines))
    line = lines.pop(place)
    again = chance.choice(([], [line, line], [b"  " + line], [line.lstrip()], [line[: len(line) // 2]]))
    place = place if chance.random() < 0.7 else chance.randrange(len(lines) + 1)
    return b"\n".join([*lines[:place], *again, *lines[place:]])


def _bytes_changed(content: bytes, chance: random.Random) -> bytes:
    """Replace a few bytes by a fragment, or cut the rest off."""
    begin = chance.randrange(len(content) + 1)
    if chance.random() < 0.2:
        return content[:begin]
    return content[:begin] + chance.choice(FRAGMENTS) + content[begin + chance.randint(0, 12) :]


def _own_section(content: bytes, chance: random.Random) -> bytes:
    """Add a section with a value that a parameter of a node cannot take."""
    node = chance.choice(PARAMETRISED)
    name = chance.choice(describe(NODE_BY_NAME[node].parameters_type())).name
    section = f"\n/**/{node}: {{ros__parameters: {{{name}: {chance.choice(VALUES)}}}}}\n"
    return content + section.encode("utf-8", "surrogatepass")


def changed_table(chance: random.Random, path: Path) -> Path:
    """Write a table of one case to `path` whose scenario, files or bytes are changed; return the path."""
    digest = hashlib.sha256(b"content").hexdigest()
    file: Any = {"sha256": digest, "bytes": 7}
    text = changed_scenario(chance).decode(errors="replace") if chance.random() < 0.3 else _names_a_file()
    files: Any = {"/nowhere/own.csv": file}
    for _ in range(chance.randint(1, 2)):
        which = chance.randrange(5)
        if which == 0:
            file["sha256"] = chance.choice(("../../up", "/tmp/hostile", "a", digest[:-1], digest.upper(), "\n" * 64))
        elif which == 1:
            file["bytes"] = chance.choice(SIZES)
        elif which == 2:
            files = {str(chance.choice(NAMES)): file}
        elif which == 3:
            files = chance.choice(({}, [], 7, {"/": file}, {"/dev/zero": file}, {"/nowhere/own.csv": 7}, None))
    columns: dict[str, Any] = {"case": [1], "seed": [1], "nominal": [False], "failure": [""], "tension_max_n": [1.0]}
    columns |= {"scenario": [text], "files": [json.dumps(files)]}
    if chance.random() < 0.1:
        columns[chance.choice(list(columns))] = [chance.choice((None, 7, 1.5, [1], {"a": 1}, b"\xff"))]
    if chance.random() < 0.05:
        count = 300_000
        same = pyarrow.DictionaryArray.from_arrays(pyarrow.array([0] * count, pyarrow.int32()), ["x" * 20_000])
        columns = {"case": pyarrow.array(range(count)), "scenario": same}
    pyarrow.parquet.write_table(pyarrow.table(columns), path)
    if chance.random() < 0.3:
        content = bytearray(path.read_bytes())
        for _ in range(chance.randint(1, 20)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        path.write_bytes(content)
    return path


def _names_a_file() -> str:
    sections = read_sections(shipped_scenarios()["unit_1500"])
    sections.setdefault("/**/wave_vessel", {})["vessel.rao_file"] = "/nowhere/own.csv"
    return sections_text(sections)

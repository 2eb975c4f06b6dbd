#!/usr/bin/env python3
"""Prints docs/messages.md, from the table of channels in runtime/channel_table.hpp and the types in lcmtypes/.

Usage: message_page.py [--check FILE]

  --check FILE   print nothing; exit code 1 if FILE is not what would be printed
"""
import pathlib
import re
import sys
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[1]

INTRODUCTION = """# Messages

All channels and message types. `tools/reference_pages.sh` writes this page from the table in
[runtime/channel_table.hpp](../runtime/channel_table.hpp) and from [lcmtypes](../lcmtypes); how the processes use them is in [architecture](architecture.md).

W is the frame of the arm's base link. Quaternions are in the order w, x, y, z. The unit of a joint field follows from the joint's type: the first unit is that of a
revolute or continuous joint, the second that of a prismatic one.

## Channels

Names are those of the programs, without `multireach-`; `lcm-logger` records all channels.

"""
# Endings of field names; the first that fits counts.
UNITS = {"_rad2_m2": "rad²/m²", "_m2_s2": "m²/s²", "_rad_s": "rad/s", "_m_s": "m/s", "_m2": "m²", "_rad": "rad", "_px": "px",
         "_us": "µs", "_m": "m", "_n": "N"}
JOINT_UNITS = {"joint_position": "rad, m", "joint_velocity": "rad/s, m/s", "joint_effort": "N m, N"}


@dataclass
class Member:
    """A field or a constant."""
    type: str
    name: str
    value: str  # of a constant; lengths of an array, as "[3][3]"
    comment: str

    def unit(self):
        if self.name == "utime":
            return "µs"
        for ending, unit in JOINT_UNITS.items():
            if self.name.endswith(ending):
                return unit
        return next((unit for ending, unit in UNITS.items() if self.name.endswith(ending)), "")


@dataclass
class Type:
    name: str
    comment: list                                  # lines
    constants: list = field(default_factory=list)
    fields: list = field(default_factory=list)


def read_type(path):
    """A file of lcmtypes: a comment, then one struct whose members have their comments behind them, or on the lines below."""
    comment, found, newest = [], None, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        code, _, text = line.partition("//")
        code, text = code.strip(), text.rstrip()
        if found is None:
            if code.startswith("struct"):
                found = Type(code.split()[1], comment)
            elif text:
                comment.append(text)
            continue
        constant = re.fullmatch(r"const (\w+) (\w+) = (-?\d+);", code)
        member = re.fullmatch(r"(\w+) (\w+)((?:\[\w+\])*);", code)
        if constant or member:
            newest = Member(*(constant or member).groups(), text.strip())
            (found.constants if constant else found.fields).append(newest)
        elif text and not code and newest:
            newest.comment = f"{newest.comment} {text.strip()}".strip()
        elif code not in ("", "{", "}"):
            sys.exit(f"message_page.py: {path}:{number}: not understood: {line}")
    return found


@dataclass
class Channel:
    name: str
    type: str
    sent: str
    senders: str
    receivers: str


def read_channels(folder):
    """The rows of kChannels in channel_table.hpp, whose first entry is a constant of channels.hpp."""
    names = dict(re.findall(r'string_view (k\w+) = "(\w+)";', (folder / "channels.hpp").read_text()))
    path = folder / "channel_table.hpp"
    text = path.read_text()
    table = re.search(r"kChannels\{(.*?)\};", text, re.DOTALL)[1]
    table = re.sub(r'"\s*\n\s*"', "", table)  # a string on two lines
    rows = re.findall(r'Channel\{(k\w+),\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)"\}', table)
    if len(rows) != table.count("Channel{"):
        sys.exit(f"message_page.py: {path}: a row of kChannels is not understood")
    return [Channel(names[row[0]], *row[1:]) for row in rows]


def linked(text):
    """Names of pages as links."""
    return re.sub(r"\bdocs/(\w[\w-]*\.md)", r"[docs/\1](\1)", text)


def cell(text):
    return linked(text.replace("|", "\\|"))


def members_table(heads, rows):
    yield "| " + " | ".join(heads) + " |"
    yield "|" + "---|" * len(heads)
    for row in rows:
        yield "| " + " | ".join(map(cell, row)) + " |"
    yield ""


def paragraphs(lines):
    """A comment as Markdown: its indented lines are a list, "  NAME   text"."""
    in_list = False
    for line in lines:
        entry = re.match(r"\s{3}(\w+)\s+(.*)", line)
        if entry:
            if not in_list:
                yield ""
            yield f"- {entry[1]}: {entry[2]}"
        else:
            yield linked(line.strip())
        in_list = bool(entry)
    yield ""


def page(channels, types):
    out = [INTRODUCTION.rstrip(), ""]
    out += members_table(["channel", "type", "sent", "by", "to"],
                         [[f"`{c.name}`", f"[`{c.type}`](#{c.type})", c.sent, c.senders, c.receivers] for c in channels])
    out += ["## Types", ""]
    used = {name for t in types.values() for member in t.fields for name in [member.type] if name in types}
    for t in types.values():
        on = [f"`{c.name}`" for c in channels if c.type == t.name]
        inside = [f"[`{o.name}`](#{o.name})" for o in types.values() if any(member.type == t.name for member in o.fields)]
        out += [f"### {t.name}", ""]
        out += paragraphs(t.comment)
        if on or inside:
            out += [" ".join((["On " + ", ".join(on) + "."] if on else []) + (["Part of " + ", ".join(inside) + "."] if inside else [])), ""]
        elif t.name not in used:
            sys.exit(f"message_page.py: {t.name} is on no channel and in no other type")
        if t.constants:
            out += members_table(["constant", "value", ""], [[f"`{m.name}`", m.value, m.comment] for m in t.constants])
        out += members_table(["field", "type", "unit", ""], [
            [f"`{m.name}`", f"[`{m.type}`](#{m.type}){m.value}" if m.type in types else f"`{m.type}{m.value}`", m.unit(), m.comment] for m in t.fields])
    return "\n".join(out).rstrip() + "\n"


def main(arguments):
    if arguments and (len(arguments) != 2 or arguments[0] != "--check"):
        print(__doc__)
        return 0 if arguments == ["--help"] else 2
    types = {t.name: t for t in map(read_type, sorted((ROOT / "lcmtypes").glob("*.lcm")))}
    text = page(read_channels(ROOT / "runtime"), types)
    if not arguments:
        print(text, end="")
        return 0
    if pathlib.Path(arguments[1]).read_text() != text:
        print(f"message_page.py: {arguments[1]} is not current: run tools/reference_pages.sh", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

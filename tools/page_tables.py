#!/usr/bin/env python3
"""Fills in the tables of the pages from the files of results.

Usage: page_tables.py [--results DIR] [--into DIR] [PAGE...]      default: README.md and all pages of docs/

A table stands in a page between two comments, of which the first names the file, as a link of the page would:

    <!-- table: results/laws.md -->             the only table of this file, and the date of its measurement
    <!-- table: results/ik.md#solved -->        the table under the heading "Solved" of a file with several
    <!-- table: results/measures.csv fig1 -->   the quantities of fig1, with a column for each law; "fig1 by law": with a row for each
    <!-- end of table -->

A block of text between ```text and ``` in a file of results counts as a table. A table whose file does not exist stays as it is.
tools/numbers.sh writes the first two kinds of file, studies/figures.sh the third; a figure without rows in it keeps its table.
--results: read the files, by their names alone, from this folder. --into: write the pages there.
"""
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
BEGIN, END = "<!-- table: ", "<!-- end of table -->"
BLOCK = re.compile(rf"(?P<begin>{BEGIN}(?P<file>[^ #]+)(#(?P<section>[\w-]+))?( (?P<figure>[\w-]+)(?P<by_law> by law)?)? -->\n)(?P<old>.*?)"
                   rf"(?P<end>{END}\n)", re.DOTALL)


class Wrong(Exception):
    pass


def anchor(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def sections(text):
    """The tables and blocks of text of a file of results, by the anchor of their heading; "" for the title."""
    found, section, inside = {}, "", False
    for line in text.splitlines():
        fence = line.startswith("```")
        if line.startswith("## ") and not inside:
            section = anchor(line[3:])
        elif line.startswith("|") or fence or inside:
            found[section] = found.get(section, "") + line + "\n"
        inside ^= fence
    return found


def pages_with_tables():
    return [path for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))) if BEGIN in path.read_text()]


def date_of(text):
    match = re.search(r"^- Measured: (\d{4}-\d\d-\d\d)", text, re.MULTILINE)
    if not match:
        raise Wrong("does not say when it was measured: expected a line '- Measured: DATE'")
    return match[1]


def shown(value):
    """A number as the tables of figures show it: four digits."""
    if not value:
        return ""
    number = float(value)
    if number != number:
        return "–"
    if number and abs(number) < 1e-3:
        return "< 0.001"
    return f"{number:.0f}" if number >= 10000 else f"{number:.4g}"


def measured(path, figure, by_law):
    """The table of one figure, from rows of figure, law, quantity, value, unit; None if there are none."""
    values, laws, quantities = {}, {}, {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            if row["figure"] == figure:
                quantity = row["quantity"] + (f" ({row['unit']})" if row["unit"] else "")
                values[row["law"], quantity] = row["value"]
                laws[row["law"]] = quantities[quantity] = None
    if not values:
        return None
    rows, columns = (laws, quantities) if by_law else (quantities, laws)
    lines = [["", *columns]]
    lines += [[row, *(shown(values.get((row, column) if by_law else (column, row), "")) for column in columns)] for row in rows]
    head, *body = ["| " + " | ".join(line) + " |\n" for line in lines]
    return "".join([head, "|---" * len(lines[0]) + "|\n", *body])


def table(block, folder, results):
    """What stands between the comments of a block of a page in `folder`."""
    path = (folder if results is None else results) / (block["file"] if results is None else pathlib.Path(block["file"]).name)
    if not path.is_file():
        if block["old"]:
            return block["old"]
        raise Wrong(f"there is no {block['file']}")
    if block["figure"]:
        made = measured(path, block["figure"], block["by_law"])
        return block["old"] if made is None else made
    text = path.read_text()
    tables = sections(text)
    if block["section"] is None and len(tables) == 1:
        made = next(iter(tables.values()))
    elif (block["section"] or "") in tables:
        made = tables[block["section"] or ""]
    else:
        raise Wrong(f"{block['file']} has no table {block['section'] or 'of its own'}; it has: {', '.join(tables)}")
    return f"{made}\nMeasured on {date_of(text)}: [command and computer]({block['file']}).\n"


def filled(text, folder, results=None):
    """The text of a page in `folder` with its tables as the files have them."""
    for marker in re.findall(re.escape(BEGIN) + ".*", text):
        if not any(block["begin"] == marker + "\n" for block in BLOCK.finditer(text)):
            raise Wrong(f"'{marker}' is not understood, or '{END}' is missing after it")
    return BLOCK.sub(lambda block: block["begin"] + table(block, folder, results) + block["end"], text)


def main(arguments):
    options, pages = {}, []
    while arguments:
        word = arguments.pop(0)
        if word in ("--results", "--into"):
            if not arguments:
                raise Wrong(f"{word} needs a folder")
            options[word] = pathlib.Path(arguments.pop(0))
        elif word in ("--help", "-h"):
            print(__doc__.strip())
            return
        elif word.startswith("-"):
            raise Wrong(f"unknown option '{word}'; see --help")
        else:
            pages.append(pathlib.Path(word))
    for page in pages or pages_with_tables():
        text = page.read_text()
        try:
            new = filled(text, page.parent, options.get("--results"))
        except Wrong as error:
            raise Wrong(f"{page}: {error}") from None
        target = options["--into"] / page.name if "--into" in options else page
        if target != page or new != text:
            target.write_text(new)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except Wrong as error:
        sys.exit(f"page_tables.py: {error}")

"""Every table that a page takes from a file of docs/results is that of the file, every file is in a page and in docs/numbers.md, and its
command is the one that tools/numbers.sh runs."""
import csv
import pathlib
import re
import subprocess

import pytest

import page_tables
from page_text import ROOT

RESULTS = ROOT / "docs/results"


def pages():
    return {str(path.relative_to(ROOT)): path.read_text() for path in page_tables.pages_with_tables()}


def listed():
    """The commands of tools/numbers.sh, by the name of the table."""
    done = subprocess.run([ROOT / "tools/numbers.sh", "--list"], capture_output=True, text=True, check=True)
    return dict(line.split("\t") for line in done.stdout.splitlines())


def faults_of_pages(texts, commands, results=RESULTS):
    """Pages whose tables are not those of the files, or of no command, and tables of files that are in no page."""
    used = set()
    for name, text in texts.items():
        try:
            if page_tables.filled(text, (ROOT / name).parent, results) != text:
                yield f"{name} has other tables than the files of docs/results: run tools/numbers.sh --fill"
        except page_tables.Wrong as error:
            yield f"{name}: {error}"
        for file in {pathlib.Path(block["file"]) for block in page_tables.BLOCK.finditer(text)}:
            if file.name != "measures.csv" and file.stem not in commands:
                yield f"{name}: tools/numbers.sh does not list {file.stem}"
        used |= {(pathlib.Path(block["file"]).name, block["section"] or block["figure"] or "") for block in page_tables.BLOCK.finditer(text)}
    with open(results / "measures.csv", newline="") as file:
        there = {("measures.csv", row["figure"]) for row in csv.DictReader(file)}
    for path in results.glob("*.md"):
        tables = page_tables.sections(path.read_text())
        there |= {(path.name, "" if len(tables) == 1 else section) for section in tables}
    yield from (f"no page has the table {section or 'of'} {'of ' if section else ''}docs/results/{file}" for file, section in sorted(there - used))


def faults_of_files(files, commands, numbers):
    """Files without what a reader must know of a measurement, or of another command than that of tools/numbers.sh, or not in docs/numbers.md, which
    also names the tables that are still without a file."""
    for name in sorted(set(files) | set(commands)):
        by_hand = f"`tools/numbers.sh {name}`" in numbers
        if name not in files:
            if not by_hand:
                yield f"docs/results/{name}.md is missing: run tools/numbers.sh {name}"
            continue
        if by_hand:
            yield f"docs/numbers.md says that {name} is copied by hand"
        if name not in commands:
            yield f"tools/numbers.sh does not list {name}"
        elif not re.search(rf"^- Command: `{re.escape(commands[name])}( .*)?`$", files[name], re.MULTILINE):
            yield f"docs/results/{name}.md is of another command: run tools/numbers.sh {name}"
        for what in ("Measured: 20\\d\\d-", "Version: ", "Computer: .* processors", "Compiler: "):
            if not re.search(f"^- {what}", files[name], re.MULTILINE):
                yield f"docs/results/{name}.md has no line '- {what}'"
        if not re.search("^- Version: .*, commit [0-9a-f]{7}", files[name], re.MULTILINE):
            yield f"docs/results/{name}.md does not name the commit"
        if f"(results/{name}.md)" not in numbers:
            yield f"docs/numbers.md does not list results/{name}.md"


def test_tables_are_those_of_the_files():
    assert len(pages()) > 3
    assert not list(faults_of_pages(pages(), listed()))


def test_files_say_how_they_were_measured():
    files = {path.stem: path.read_text() for path in RESULTS.glob("*.md")}
    assert not list(faults_of_files(files, listed(), (ROOT / "docs/numbers.md").read_text()))


COMMANDS = {"some": "multireach-some", "unused": "multireach-unused"}
FILE = """# Some

- Command: `multireach-some`
- Measured: 2027-01-02, in 3 s
- Version: 0.1.0 of 2026-01-01, commit 0123abc
- Computer: Some, 2 processors
- Compiler: GCC 12

## First of two

| a | b |
|---|---|
| 1 | 2 |

## Second

| c |
|---|
| 3 |

## What a program printed

```text
## a
 1.5
```
"""
PAGE = """# Page

<!-- table: results/some.md#second -->
| c |
|---|
| 3 |

Measured on 2027-01-02: [command and computer](results/some.md).
<!-- end of table -->

<!-- table: results/some.md#first-of-two -->
<!-- end of table -->

<!-- table: results/some.md#what-a-program-printed -->
<!-- end of table -->

<!-- table: results/measures.csv fig by law -->
<!-- end of table -->

<!-- table: results/measures.csv fig -->
<!-- end of table -->
"""


@pytest.fixture
def results(tmp_path):
    (tmp_path / "some.md").write_text(FILE)
    (tmp_path / "measures.csv").write_text("figure,law,quantity,value,unit\nfig,x,way,0.00012,m\nfig,y,way,20000.4,m\nfig,x,reaches,7,\nfig,y,time,nan,s\n")
    return tmp_path


def test_a_page_is_filled(results):
    made = page_tables.filled(PAGE, ROOT, results)
    assert "first-of-two -->\n| a | b |\n|---|---|\n| 1 | 2 |\n\nMeasured on 2027-01-02: [command and computer](results/some.md).\n<!-- end" in made
    assert "printed -->\n```text\n## a\n 1.5\n```\n\nMeasured" in made
    assert "by law -->\n|  | way (m) | reaches | time (s) |\n|---|---|---|---|\n| x | < 0.001 | 7 |  |\n| y | 20000 |  | – |\n<!-- end" in made
    assert "fig -->\n|  | x | y |\n|---|---|---|\n| way (m) | < 0.001 | 20000 |\n| reaches | 7 |  |\n| time (s) |  | – |\n<!-- end" in made
    assert page_tables.filled(made, ROOT, results) == made
    assert not list(faults_of_pages({"docs/page.md": made}, COMMANDS, results))


def test_what_is_wrong_with_a_page_is_found(results):
    made = page_tables.filled(PAGE, ROOT, results)
    other = "docs/page.md has other tables than the files of docs/results: run tools/numbers.sh --fill"
    assert list(faults_of_pages({"docs/page.md": made.replace("| 3 |", "| 4 |")}, COMMANDS, results)) == [other]
    assert list(faults_of_pages({"docs/page.md": made.replace("2027-01-02", "2027-01-03", 1)}, COMMANDS, results)) == [other]
    (results / "unused.md").write_text(FILE.split("## Second")[0])
    assert list(faults_of_pages({"docs/page.md": made}, COMMANDS, results)) == ["no page has the table of docs/results/unused.md"]
    for change, error in (("#third", "results/some.md has no table third"), (".gone", "tools/numbers.sh does not list some.md"),
                          (" fig what", "is not understood")):
        assert error in list(faults_of_pages({"docs/page.md": made.replace("some.md#second", "some.md" + change)}, COMMANDS, results))[0]


def test_what_is_wrong_with_a_file_is_found():
    numbers = "[some](results/some.md)"
    assert not list(faults_of_files({"some": FILE}, {"some": "multireach-some"}, numbers))
    assert not list(faults_of_files({}, {"some": "multireach-some"}, "`tools/numbers.sh some`"))
    assert not list(faults_of_files({"some": FILE.replace("-some`", "-some --reaches 3`")}, {"some": "multireach-some"}, numbers))
    for files, commands, text, fault in (
            ({}, {"some": "x"}, numbers, "docs/results/some.md is missing: run tools/numbers.sh some"),
            ({"some": FILE}, {}, numbers, "tools/numbers.sh does not list some"),
            ({"some": FILE}, {"some": "multireach-some -n"}, numbers, "docs/results/some.md is of another command: run tools/numbers.sh some"),
            ({"some": FILE.replace(", commit 0123abc", "")}, {"some": "multireach-some"}, numbers,
             "docs/results/some.md does not name the commit"),
            ({}, {"some": "multireach-some"}, "", "docs/results/some.md is missing: run tools/numbers.sh some"),
            ({"some": FILE}, {"some": "multireach-some"}, numbers + "`tools/numbers.sh some`", "docs/numbers.md says that some is copied by hand"),
            ({"some": FILE.replace("- Compiler", "")}, {"some": "multireach-some"}, numbers, "docs/results/some.md has no line '- Compiler: '"),
            ({"some": FILE}, {"some": "multireach-some"}, "", "docs/numbers.md does not list results/some.md")):
        assert list(faults_of_files(files, commands, text)) == [fault]


@pytest.mark.parametrize("arguments, fault", [
    (["nothing"], "unknown table 'nothing'; expected one of: "),
    (["--nothing"], "unknown option '--nothing'"),
    (["laws", "step", "--", "3"], "-- expects one table before it"),
    (["--", "3"], "-- expects one table before it")])
def test_wrong_arguments_of_numbers(arguments, fault):
    done = subprocess.run([ROOT / "tools/numbers.sh", *arguments], capture_output=True, text=True)
    assert done.returncode == 2 and fault in done.stderr

"""docs/numbers.md names every table of numbers."""
import re

import pytest

import doc_site
from page_text import GENERATED, ROOT, page_names

FEW = 3  # a table with fewer decimal numbers is no table of measurements


def tables_of(text):
    """Of each table with numbers: its line, and the anchor of its section."""
    used, anchor, begin, inside = {}, "", 0, []
    for number, line in enumerate(text.splitlines() + [""], 1):
        if line.lstrip().startswith("|"):
            begin = begin if inside else number
            inside.append(line)
            continue
        body = re.sub(r"`[^`]*`|\([^)]*\.md[^)]*\)", "", "\n".join(inside[2:]))
        if len(re.findall(r"\d\.\d", body)) >= FEW:
            yield begin, anchor
        inside = []
        if line.startswith("#"):
            anchor = doc_site.slug(line.lstrip("# "), used)


def faults(pages, named):
    for page, text in pages.items():
        for line, anchor in tables_of(text):
            if not {page, f"{page}#{anchor}"} & named:
                yield f"{page}:{line}: docs/numbers.md does not say where this table comes from; expected a link to {page}#{anchor}"


@pytest.fixture
def named():
    links = re.findall(r"\]\(([^)]+)\)", (ROOT / "docs/numbers.md").read_text())
    return {"README.md" + link.removeprefix("../README.md") if link.startswith("../") else f"docs/{link}" for link in links}


def test_every_table_of_numbers_has_its_command(named):
    # The pages of the arms say themselves, number by number.
    pages = {page: (ROOT / page).read_text() for page in page_names() if not GENERATED.fullmatch(page) and not page.startswith("robots/")}
    assert not list(faults(pages, named))


def test_a_table_without_its_command_is_found(named):
    page = "# New\n\n## Results\n\n| a | b |\n|---|---|\n| 1.2 | 2.3 |\n| 4.5 | 5.6 |\n"
    assert list(faults({"docs/new.md": page}, named)) == [
        "docs/new.md:5: docs/numbers.md does not say where this table comes from; expected a link to docs/new.md#results"]
    assert not list(faults({"docs/new.md": page}, named | {"docs/new.md#results"}))

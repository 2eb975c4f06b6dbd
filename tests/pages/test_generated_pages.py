"""The pages that are made from the programs and the messages are current; the table of channels agrees with the architecture; the site
refuses broken links."""
import re
import subprocess
import sys

import pytest

import doc_site
import message_page
import program_pages
from page_text import ROOT


def commands(bin_folder):
    listed = subprocess.run([ROOT / "tools/reference_pages.sh", "--list", bin_folder], capture_output=True, text=True, check=True)
    return listed.stdout.split()


def test_program_pages_are_current(bin_folder, tmp_path):
    program_pages.main(["--markdown", str(tmp_path), *commands(bin_folder)])
    made = {path.name: path.read_text() for path in tmp_path.iterdir()}
    there = {path.name: path.read_text() for path in (ROOT / "docs/programs").iterdir()}
    assert sorted(made) == sorted(there), "run tools/reference_pages.sh"
    for name, text in made.items():
        assert there[name] == text, f"docs/programs/{name} is not current: run tools/reference_pages.sh"


def test_every_program_has_a_page(bin_folder):
    programs = {path.name for path in bin_folder.glob("multireach-*") if not re.match(r"multireach-(test|fuzz|bench)-", path.name)}
    assert programs <= {command.rpartition("/")[2] for command in commands(bin_folder)}


def test_message_page_is_current():
    assert message_page.main(["--check", str(ROOT / "docs/messages.md")]) == 0


def test_the_architecture_has_all_channels():
    table = (ROOT / "docs/architecture.md").read_text().split("## Processes and channels")[1].split("\n## ")[0]
    rows = [line.split("|") for line in table.splitlines() if line.startswith("| `")]
    pairs = {(channel, kind) for row in rows for channel, kind in zip(re.findall(r"`(\w+)`", row[1]), re.findall(r"`(\w+)`", row[2]))}
    assert pairs == {(channel.name, channel.type) for channel in message_page.read_channels(ROOT / "runtime")}


def test_a_line_that_is_no_member_is_an_error(tmp_path):
    file = tmp_path / "wrong_t.lcm"
    file.write_text("package multireach;\n// Comment.\nstruct wrong_t\n{\n  int32_t n\n}\n")
    with pytest.raises(SystemExit, match="wrong_t.lcm:5: not understood"):
        message_page.read_type(file)


def test_markdown_page_of_a_program(tmp_path):
    program = tmp_path / "mover"
    program.write_text("#!/bin/sh\ncat <<'EOT'\nMoves <things>.\nUsage: mover [OPTIONS]\n\nOptions:\n  --law TEXT:{a|b}   of | both\nEOT\n")
    program.chmod(0o755)
    program_pages.main(["--markdown", str(tmp_path / "pages"), str(program)])
    page = (tmp_path / "pages/mover.md").read_text()
    assert "| `--law TEXT:{a\\|b}` | of \\| both |" in page and "Moves \\<things\\>." in page
    assert "| [mover](mover.md) | Moves \\<things\\> |" in (tmp_path / "pages/README.md").read_text()


@pytest.fixture
def tree(tmp_path):
    """A project of two pages and a file, all of whose links are right."""
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text("# A project\n\n[to a page](docs/page.md#with-a-heading), [to a file](docs/x.py)\n")
    (tmp_path / "docs/page.md").write_text("# Page\n\n## With *a* heading?\n\n[back](../README.md) [here](#with-a-heading)\n")
    (tmp_path / "docs/x.py").write_text("a < b\n")
    return tmp_path


def test_site_of_right_links(tree):
    site = doc_site.Site(tree, {"Begin": ["README.md"], "Folders": []})
    assert site.check() == []
    site.write(tree / "site")
    assert 'href="docs/page.html#with-a-heading"' in (tree / "site/index.html").read_text()
    assert 'id="with-a-heading"' in (tree / "site/docs/page.html").read_text()
    assert "a &lt; b" in (tree / "site/docs/x.py.html").read_text()


@pytest.mark.parametrize("text, error", [
    ("[x](docs/none.md)", "there is no file docs/none.md"), ("[x](docs/page.md#none)", "has no heading with this anchor"),
    ("![x](none.png)", "there is no file none.png"), ("[x](#none)", "has no heading"), ("[x](docs/x.py#L3)", "has no heading")])
def test_site_refuses_broken_links(tree, text, error):
    with open(tree / "README.md", "a") as file:
        file.write(text + "\n")
    assert any(error in each for each in doc_site.Site(tree, {"Folders": []}).check())


def test_site_refuses_a_page_without_links_to_it(tree):
    (tree / "docs/lost.md").write_text("# Lost\n")
    assert doc_site.Site(tree, {"Folders": []}).check() == ["docs/lost.md: no page links to this page"]

"""Reads the pages: their blocks of code, and the commands in them."""
import pathlib
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tools"), str(ROOT / "tests/python")]  # the modules that are tested, and what tests share

from doc_site import project_files  # noqa: E402

NAMESPACE = "{http://commonmark.org/xml/1.0}"
SCRIPTS = {"multireach-launch": "tools/launch.sh", "multireach-doctor": "tools/doctor.sh", "multireach-spy": "tools/spy.sh"}  # installed, and here
GENERATED = re.compile(r"docs/(programs/.*|messages|configuration)\.md")


@dataclass(frozen=True)
class Code:
    """A block of code, or code in a sentence (language None)."""
    page: str
    line: int
    language: str
    text: str


def page_names():
    return [name for name in project_files(ROOT) if name.endswith(".md")]


def code_of(page):
    done = subprocess.run(["cmark-gfm", "-e", "table", "-t", "xml", "--sourcepos", ROOT / page], capture_output=True, text=True, check=True)
    line, found = 0, []
    for element in xml.etree.ElementTree.fromstring(done.stdout).iter():
        line = int(element.get("sourcepos", f"{line}:").split(":")[0])
        if element.tag == NAMESPACE + "code_block":
            found.append(Code(page, line, (element.get("info") or "").strip(), element.text))
        elif element.tag == NAMESPACE + "code":
            found.append(Code(page, line, None, element.text))
    return found


@dataclass(frozen=True)
class Command:
    """A line of a block without a language, or of a script, as it stands: with its continuation lines, without its comment."""
    page: str
    line: int
    text: str

    def simple_commands(self):
        """Its words, for each command that the line starts."""
        text = re.sub(r"\$\([^()]*\)", "SUBSTITUTED", self.text)
        words, found = shlex.shlex(text, posix=True, punctuation_chars=";|&<>"), []
        words.whitespace_split = True
        current = []
        for word in words:
            if re.fullmatch(r"[;|&]+", word):
                found.append(current)
                current = []
            else:
                current.append(word)
        found.append(current)
        return [words for words in map(without_redirection, found) if words]


def without_redirection(words):
    kept, skip = [], False
    for word in words:
        if re.fullmatch(r"[<>&]+", word):
            skip = True
        elif skip:
            skip = False
        else:
            kept.append(word)
    while kept and re.fullmatch(r"\w+=.*", kept[0]):
        kept.pop(0)
    return kept


def without_comment(line):
    """A `#` begins a comment at the start of a word outside of quotes."""
    quote = ""
    for i, c in enumerate(line):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c == "#" and (i == 0 or line[i - 1].isspace()):
            return line[:i]
    return line


def commands_of(code):
    found, begun = [], ""
    for number, line in enumerate(code.text.splitlines(), code.line):
        line = without_comment(line).rstrip()
        if line.endswith("\\"):
            begun += line[:-1]
        elif (begun + line).strip():
            found.append(Command(code.page, number, " ".join((begun + line).split())))
            begun = ""
    return found


def all_commands():
    return [command for page in page_names() if not GENERATED.fullmatch(page) for code in code_of(page) if code.language in ("", "sh")
            for command in commands_of(code)]

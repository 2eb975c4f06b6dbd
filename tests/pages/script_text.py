"""What a test script runs, as far as its text tells: a line that has a program and its options, in itself or by the functions and variables that it uses."""
import re

from page_text import SCRIPTS

SOURCED = re.compile(r'^\s*\. .*?([\w-]+\.sh)"?', re.MULTILINE)
FUNCTION = re.compile(r"^(\w+)\(\) \{(?: (.*)\}$|\n((?:[^\n]*\n)*?)\})", re.MULTILINE)
VARIABLE = re.compile(r"""^\s*(?:declare |local )?(\w+)\+?=(\((?:[^()]|\$\([^)]*\))*\)|"[^"]*"|'[^']*'|\S+)""", re.MULTILINE)

OTHER_NAMES = {"apt": ["apt-get"], "g++": ["{CXX:-c++}"], **{script.rsplit("/")[-1]: [name] for name, script in SCRIPTS.items()}}


def whole_text(path):
    """With the scripts of its folder and of tests/live that it sources."""
    text = path.read_text()
    for name in SOURCED.findall(text):
        for folder in (path.parent, path.parent.parent / "live"):
            if (folder / name).exists() and folder / name != path:
                text += "\n" + (folder / name).read_text()
                break
    return text


def logical_lines(text):
    return [re.sub(r"(^|\s)#.*", "", line) for line in re.sub(r"\\\n\s*", " ", text).splitlines()]


def expanded_lines(text):
    """Each line, with the text of the functions and variables that it names, and that these name."""
    text = "\n".join(logical_lines(text))
    meaning = {}
    for name, short, long in FUNCTION.findall(text):
        meaning.setdefault(name, []).append(short or long)
    for name, value in VARIABLE.findall(text):
        meaning.setdefault("$" + name, []).append(value)
    for line in text.splitlines():
        seen, new = set(), [line]
        whole = line
        while new:
            part = new.pop()
            names = {"$" + name for name in re.findall(r"\$\{?!?(\w+)", part)} | set(re.findall(r"(?<![\w$./-])\w+(?![\w=])", part))
            for name in (names & meaning.keys()) - seen:
                seen.add(name)
                new += meaning[name]
                whole += "\n" + "\n".join(meaning[name])
        yield whole


def has_word(text, word):
    return re.search(rf"(?<![\w-]){re.escape(word)}(?![\w-])", text)


def runs(text, program, words):
    """Whether a line of the text runs the program with all of the words: options, subcommands."""
    names = {program, *OTHER_NAMES.get(program, ())}
    if program.startswith("multireach-"):
        names.add(program.replace("-", " ", 1))
    return any(any(has_word(line, name) for name in names) and all(has_word(line, word) for word in words) for line in expanded_lines(text))

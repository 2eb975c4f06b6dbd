#!/usr/bin/env python3
"""Writes the man page and the bash completion of programs and scripts, or pages of the docs, from what they print for --help.

Usage: program_pages.py FOLDER VERSION COMMAND...
       program_pages.py --markdown FOLDER COMMAND...

FOLDER/man/NAME.1.gz and FOLDER/completions/NAME, or FOLDER/NAME.md and a list of these pages, FOLDER/README.md. NAME is that of
the file COMMAND, or as COMMAND=NAME.
"""
import gzip
import pathlib
import re
import subprocess
import sys
from dataclasses import dataclass, field


@dataclass
class Entry:
    """An option, an argument or a subcommand: its name with all names of its value, and its text."""
    name: str
    text: str

    def flags(self):
        """The words with which an option may be given, as ["-o", "--output"]; none for an argument."""
        return re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", re.split(r" (?:Excludes|Needs):", self.name)[0])

    def choices(self):
        """The values that an option may have, where they are listed."""
        found = re.search(r"\{([^}]*)\}", self.name)
        return re.split(r"[,|]", found[1]) if found else []

    def takes_value(self):
        return bool(re.search(r"\s\S", re.split(r" (?:Excludes|Needs):", self.name)[0].strip()))


@dataclass
class Help:
    """What a program prints for --help, in parts."""
    description: str = ""
    usage: str = ""
    sections: dict = field(default_factory=dict)  # heading -> entries, in order
    notes: list = field(default_factory=list)     # lines that follow the options
    subcommands: dict = field(default_factory=dict)

    def entries(self, heading):
        return self.sections.get(heading, [])

    def options(self):
        return [entry for heading, entries in self.sections.items() if heading != "Subcommands"
                for entry in entries if entry.flags()]


def column_of_texts(text):
    """Where the texts of most entries begin; 0 where there is none."""
    columns = [len(begin) for begin in re.findall(r"^( {1,3}\S.*?\S? {2,})\S", text, re.MULTILINE)]
    return max(set(columns), key=columns.count, default=0)


def name_and_text(line, column):
    """The parts of an entry's first line. A name that ends just before the column has only one space behind it; one that
    reaches beyond has its text on the next line."""
    if re.search(r"\b(Needs|Excludes):( --\S+)+$", line.rstrip()):
        return line.strip(), ""
    if 0 < column < len(line) and line[column - 1] == " " != line[column] and not re.search(r"\S {2,}\S", line[:column]):
        return line[:column].strip(), line[column:].strip()
    name, _, rest = re.sub(r"\s{2,}", "\t", line.strip(), count=1).partition("\t")
    return name, rest


def parse(text):
    """Reads the form of CLI11, and of the scripts: entries are indented by two spaces, their texts follow after two more or
    on the next lines, indented further."""
    parsed, heading, entry, column = Help(), "Options", None, column_of_texts(text)
    for line in text.splitlines():
        indent = len(line) - len(line.lstrip())
        if not line.strip():
            entry = None
        elif indent == 0 and line.startswith("Usage:"):
            parsed.usage = line.removeprefix("Usage:").strip()
        elif indent == 0 and line.endswith(":") and " " not in line.rstrip(":"):
            heading, entry = line[:-1], None
        elif indent == 0 and any(parsed.sections.values()):
            parsed.notes.append(line)
        elif indent == 0:
            parsed.description = f"{parsed.description} {line}".strip()
        elif indent <= 3:
            entry = Entry(*name_and_text(line, column))
            parsed.sections.setdefault(heading, []).append(entry)
        elif entry:
            entry.text = f"{entry.text} {line.strip()}".strip()
    return parsed


def help_of(command):
    """The parsed --help of a command (a list of words), with that of its subcommands."""
    done = subprocess.run([*command, "--help"], capture_output=True, text=True, timeout=60)
    if done.returncode != 0 or not done.stdout.strip():
        sys.exit(f"program_pages.py: {' '.join(command)} --help: exit code {done.returncode}: {done.stderr.strip()}")
    parsed = parse(done.stdout)
    for entry in parsed.entries("Subcommands"):
        name = entry.name.split()[0]
        parsed.subcommands[name] = help_of([*command, name])
    return parsed


def roff(text):
    """Text as roff: no character of it is an instruction."""
    text = text.replace("\\", "\\(rs").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def roff_entries(entries):
    for entry in entries:
        yield f".TP\n.B {roff(entry.name)}\n{roff(entry.text)}"


def title(parsed):
    return parsed.description.split(". ")[0].rstrip(".")


def man_page(name, version, parsed):
    out = [f'.TH {name.upper()} 1 "" "multireach {version}" "multireach"', ".SH NAME", f"{name} \\- {roff(title(parsed))}", ".SH SYNOPSIS",
           f".B {roff(parsed.usage or name)}", ".SH DESCRIPTION", roff(parsed.description)]
    for heading, entries in parsed.sections.items():
        if heading != "Subcommands":
            out += [f".SH {roff(heading.upper())}", *roff_entries(entries)]
    if parsed.subcommands:
        out.append(".SH SUBCOMMANDS")
        for word, sub in parsed.subcommands.items():
            out += [f".SS {roff(word)}", roff(sub.description), ".PP", f".B {roff(sub.usage)}"]
            for heading, entries in sub.sections.items():
                out += roff_entries(entry for entry in entries if "--help" not in entry.name)
            for inner, inner_help in sub.subcommands.items():
                out += [".PP", f".B {roff(word)} {roff(inner)}:", roff(inner_help.description)]
                for entries in inner_help.sections.values():
                    out += roff_entries(entry for entry in entries if "--help" not in entry.name)
    if parsed.notes:
        out.append(".SH NOTES")
        for note in parsed.notes:
            out += [roff(note), ".br"]
    if not any("xit code" in note for note in parsed.notes):
        out += [".SH EXIT STATUS", "0: done; 1: the program did not succeed; 2: wrong usage or input."]
    out += [".SH SEE ALSO", "The pages in", ".I /usr/share/doc/multireach."]
    return "\n".join(out) + "\n"


def code(text):
    return f"`{text}`".replace("|", "\\|")


def markdown_text(text):
    """Text of a table or paragraph: no character of it is Markdown."""
    return re.sub(r"([|<>*_\[\]`\\])", r"\\\1", text)


def markdown_body(name, parsed, level):
    """The parts of one program or subcommand below its heading, then its subcommands, each with a heading."""
    out = [markdown_text(parsed.description), "", "```text", parsed.usage or name, "```", ""]
    for heading, entries in parsed.sections.items():
        shown = [entry for entry in entries if level == 1 or "--help" not in entry.flags()]
        if heading != "Subcommands" and shown:
            out += [f"| {HEADINGS.get(heading, heading.lower())} | |", "|---|---|",
                    *(f"| {code(entry.name)} | {markdown_text(entry.text)} |" for entry in shown), ""]
    out += [line for note in parsed.notes for line in (markdown_text(note), "")]
    for word, sub in parsed.subcommands.items():
        out += [f"{'#' * min(level + 1, 4)} {name.removeprefix('multireach-')} {word}", "", *markdown_body(f"{name} {word}", sub, level + 1)]
    return out


HEADINGS = {"Positionals": "arguments"}


def markdown_page(name, parsed):
    return "\n".join([f"# {name}", "", *markdown_body(name, parsed, 1)]).rstrip() + "\n"


def markdown_list(helps):
    out = ["# Programs", "", "One page for each program, from its `--help`; `tools/reference_pages.sh` writes them. In the source tree, "
           "`tools/multireach log` runs `multireach-log`,", "`tools/launch.sh` is `multireach-launch`, and so on for `doctor.sh` and `spy.sh`.", "",
           "| program | |", "|---|---|"]
    out += [f"| [{name}]({name}.md) | {markdown_text(title(parsed))} |" for name, parsed in sorted(helps.items())]
    return "\n".join(out) + "\n"


def completion_cases(parsed, path=""):
    """Lines of a bash `case`: for each subcommand, its options, and what may stand there besides: subcommands, listed values of arguments."""
    options = [flag for option in parsed.options() for flag in option.flags()]
    arguments = [choice for entries in parsed.sections.values() for entry in entries if not entry.flags() for choice in entry.choices()]
    words = list(parsed.subcommands) + arguments
    yield f'    "{path}") options="{" ".join(options)}" words="{" ".join(words)}" ;;'
    for word, sub in parsed.subcommands.items():
        yield from completion_cases(sub, f"{path} {word}".strip())


def value_cases(parsed, seen):
    for option in parsed.options():
        for flag in option.flags():
            if option.takes_value() and flag not in seen:
                seen[flag] = " ".join(option.choices())
    for sub in parsed.subcommands.values():
        value_cases(sub, seen)
    return seen


def completion(name, parsed):
    function = "_" + re.sub(r"\W", "_", name)
    values = value_cases(parsed, {})
    subcommands = sorted({word for path in subcommand_paths(parsed) for word in path.split()})
    listed = "\n".join(f"    {flag}) mapfile -t COMPREPLY < <(compgen -W '{words}' -- \"$cur\"); return ;;"
                       for flag, words in values.items() if words)
    files = "|".join(flag for flag, words in values.items() if not words)
    lines = [f"# bash completion of {name}, made from its --help", f"{function}() {{",
             '  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} path="" options="" words=""' + (" i" if subcommands else ""),
             "  # --option=value is three words",
             '  [ "$cur" != = ] || cur=""',
             '  [ "$prev" != = ] || prev=${COMP_WORDS[COMP_CWORD-2]}',
             '  case "$prev" in']
    lines += [listed] if listed else []
    lines += [f"    {files}) compopt -o default; COMPREPLY=(); return ;;"] if files else []
    lines += ["  esac"]
    if subcommands:
        lines += ['  for ((i = 1; i < COMP_CWORD; i++)); do', f'    case "${{COMP_WORDS[i]}}" in {"|".join(subcommands)}) path="${{path:+$path }}${{COMP_WORDS[i]}}" ;; esac', "  done"]
    lines += ['  case "$path" in', *completion_cases(parsed), "  esac",
              '  [[ $cur != -* ]] || words=$options',
              '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")', "  [ ${#COMPREPLY[@]} -gt 0 ] || compopt -o default", "}",
              f"complete -F {function} {name}"]
    return "\n".join(lines) + "\n"


def subcommand_paths(parsed, path=""):
    for word, sub in parsed.subcommands.items():
        yield f"{path} {word}".strip()
        yield from subcommand_paths(sub, f"{path} {word}".strip())


def dispatcher_help(parsed, programs):
    """`multireach PROGRAM ...` has every other program as its subcommand."""
    parsed.subcommands = {name.removeprefix("multireach-"): sub for name, sub in programs.items() if name.startswith("multireach-")}
    return parsed


def write_markdown(folder, helps):
    folder.mkdir(parents=True, exist_ok=True)
    for name, parsed in helps.items():
        (folder / f"{name}.md").write_text(markdown_page(name, parsed))
    (folder / "README.md").write_text(markdown_list(helps))


def main(arguments):
    if len(arguments) < 3 or "--help" in arguments:
        print(__doc__)
        return 0 if "--help" in arguments else 2
    helps = {}
    for argument in arguments[2:]:
        command, _, name = argument.partition("=")
        name = name or pathlib.Path(command).name
        helps[name] = help_of([command])
        helps[name].usage = helps[name].usage.replace(pathlib.Path(command).name, name, 1)
    if arguments[0] == "--markdown":
        write_markdown(pathlib.Path(arguments[1]), helps)
        return 0
    folder, version = pathlib.Path(arguments[0]), arguments[1]
    (folder / "man").mkdir(parents=True, exist_ok=True)
    (folder / "completions").mkdir(parents=True, exist_ok=True)
    for name, parsed in helps.items():
        page = man_page(name, version, parsed).encode()
        (folder / "man" / f"{name}.1.gz").write_bytes(gzip.compress(page, mtime=0))
        parsed = dispatcher_help(parsed, helps) if name == "multireach" else parsed
        (folder / "completions" / name).write_text(completion(name, parsed))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Every command of the pages has the options, subcommands and files that its program has; tests/pages/test_scenes.py runs them.

A block of code without a language, or in `sh`, holds commands: what is not one has a language (`text`: output).
"""
import re
import subprocess
from functools import lru_cache

import pytest

import program_pages
from page_text import GENERATED, ROOT, SCRIPTS, all_commands, code_of, commands_of, page_names

# Programs of others, which have no --help of the project.
OTHERS = {"apt", "podman", "cmake", "g++", "ctest", "ninja", "lcm-gen", "lcm-logger", "lcm-logplayer", "ssh", "parallel", "scontrol", "[", "systemctl",
          "journalctl", "export", "kill", "cp", "rm", "mkdir", "cd", "git"}
# Files with these folders at their start exist; names in capitals stand for the reader's own.
FOLDERS = ("robots/", "logs/", "examples/", "docs/", "lcmtypes/", "tests/", "bench/", "studies/")


COMMANDS = all_commands()


def own_program(words, bin_folder):
    """The program or script of the project that the words start, and its arguments; None for a program of others."""
    name = words[0].removeprefix("build/release/bin/")
    if name in ("multireach", "tools/multireach") and len(words) > 1 and not words[1].startswith("-"):
        return bin_folder / f"multireach-{words[1]}", words[2:]
    if name in SCRIPTS:
        return ROOT / SCRIPTS[name], words[1:]
    if name.startswith("multireach-"):
        return bin_folder / name, words[1:]
    if re.fullmatch(r"(tools|studies|bench|web|tests|docs)/[\w/.-]+\.(sh|py)|tools/multireach", name):
        return ROOT / name, words[1:]
    if name == "/usr/bin/python3" and len(words) > 1 and words[1].endswith(".py"):
        return ROOT / words[1], words[2:]
    return None


def behind_a_wrapper(words):
    """What `parallel`, `ssh` and `podman` start: the words from the project's program on."""
    at = next((i for i, word in enumerate(words[1:], 1) if re.fullmatch(r"multireach(-[\w-]+)?", word) and words[i + 1:]
               and (word != "multireach" or not words[i + 1].startswith("multireach"))), None)
    return words[at:] if at else []


@lru_cache(maxsize=None)
def help_text(program):
    if program.suffix == ".py":
        return program.read_text()  # where its options are declared; it may need the Python module, which not every build has
    done = subprocess.run([program, "--help"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"{program} --help: {done.stderr}"
    return done.stdout


@lru_cache(maxsize=None)
def parsed_help(program):
    return program_pages.help_of([str(program)])


def faults_of_script(program, arguments):
    text = help_text(program)
    for word in arguments:
        flag = word.split("=")[0]
        if re.match(r"-[A-Za-z-]", word) and not re.search(rf"(?<![\w-]){re.escape(flag)}(?![\w-])", text):
            yield f"{program.name} --help does not name {flag}"


def faults_of_program(program, arguments):
    """What of the arguments the program's --help does not know: options, subcommands, listed values; and required options that are missing."""
    parsed, given, words = parsed_help(program), set(), list(arguments)
    known = list(parsed.options())
    while words:
        word = words.pop(0)
        flag, _, value = word.partition("=")
        if re.match(r"--?[A-Za-z]", word):
            option = next((each for each in known if flag in each.flags()), None)
            if option is None:
                yield f"{program.name} --help does not name {flag}"
                continue
            given |= set(option.flags())
            if option.takes_value() and not value and words:
                value = words.pop(0)
            if option.choices() and value and not re.search(r"[A-Z$]", value) and value not in option.choices():
                yield f"{program.name}: {flag} {value}: not one of {', '.join(option.choices())}"
        elif word in parsed.subcommands:
            parsed = parsed.subcommands[word]
            known += parsed.options()
    if re.search(r"\sSUBCOMMAND", parsed.usage) and parsed.subcommands and "[SUBCOMMAND]" not in parsed.usage:
        yield f"{program.name}: a subcommand is missing"
    for option in parsed.options():
        if "REQUIRED" in option.name and not given & set(option.flags()):
            yield f"{program.name}: {option.flags()[-1]} is required"


def faults_of(words, bin_folder):
    own = own_program(words, bin_folder)
    if own is None:
        inner = behind_a_wrapper(words)
        if words[0] not in OTHERS:
            yield f"'{words[0]}' is not a program of the project, nor one of OTHERS in tests/pages/test_commands.py; output needs ```text"
        elif inner:
            yield from faults_of(inner, bin_folder)
        return
    program, arguments = own
    if program.name.startswith("multireach-bench-"):  # few builds have these
        if not re.search(rf"\b{program.name.removeprefix('multireach-bench-')}\b", (ROOT / "bench/CMakeLists.txt").read_text()):
            yield f"bench/CMakeLists.txt has no {program.name}"
    elif not program.exists():
        yield f"there is no {program.name}"
    elif program.suffix in (".sh", ".py") or program.name == "multireach":
        yield from faults_of_script(program, arguments)
    else:
        yield from faults_of_program(program, [argument for argument in arguments if argument != ":::"])
    for word in arguments:
        if word.startswith(FOLDERS) and not re.search(r"[A-Z*]", word) and not (ROOT / word).exists():
            yield f"there is no {word}"


def test_every_command_fits_its_program(bin_folder):
    assert len(COMMANDS) > 100
    faults = []
    for command in COMMANDS:
        for words in command.simple_commands():
            faults += [f"{command.page}:{command.line}: {fault}" for fault in faults_of(words, bin_folder)]
    assert not faults, "\n".join(faults)


def test_commands_in_sentences_fit_their_programs(bin_folder):
    """They may leave out what is required, and `multireach message` is none."""
    faults, count = [], 0
    for page in page_names():
        for code in code_of(page) if not GENERATED.fullmatch(page) and page != "CHANGELOG.md" else ():
            if code.language is not None or not re.match(r"(tools/\w+(\.sh)?|multireach-[\w-]+) ", code.text) or \
                    "…" in code.text or re.search("PROGRAM", code.text):
                continue
            for command in commands_of(code):
                for words in command.simple_commands():
                    count += 1
                    faults += [f"{page}:{code.line}: `{code.text}`: {fault}" for fault in faults_of(words, bin_folder)
                               if not fault.endswith(("is required", "is missing")) and own_program(words, bin_folder)]
    assert count > 50
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("command, fault", [
    ("multireach-log info --jsn - run.lcm", "multireach-log --help does not name --jsn"),
    ("multireach-log export", "multireach-log: --output is required"),
    ("tools/multireach replay", "multireach-replay: a subcommand is missing"),
    ("tools/multireach nothing", "there is no multireach-nothing"),
    ("multireach-replay run logs/none.lcm -o out.lcm", "there is no logs/none.lcm"),
    ("multireach-replay run logs/reach.lcm --robot-model real -o out.lcm", "multireach-replay: --robot-model real: not one of ideal, sim, recorded"),
    ("tools/launch.sh --isolate", "launch.sh --help does not name --isolate"),
    ("parallel multireach-study --smples 3 ::: 1 2", "multireach-study --help does not name --smples"),
    ("wget x", "'wget' is not a program of the project, nor one of OTHERS in tests/pages/test_commands.py; output needs ```text"),
])
def test_a_wrong_command_is_found(bin_folder, command, fault):
    assert fault in list(faults_of(command.split(), bin_folder))


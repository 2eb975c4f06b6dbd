"""Every command of the pages is run, or has its options checked against --help, or is named here with the reason why neither can be done.

A block of code without a language, or in `sh`, holds commands: what is not one has a language (`text`: output).
"""
import os
import re
import shlex
import shutil
import subprocess
from functools import lru_cache

import pytest

import program_pages
from namespace import run_isolated
from page_text import GENERATED, ROOT, code_of, commands_of, page_names

# Run as they stand, in this order, in a folder that `inputs` fills.
RUN = [
    "tools/multireach log info run.lcm",
    "tools/multireach log latency run.lcm",
    "tools/multireach log export mcap run.lcm -o run.mcap",
    "multireach-log info run.lcm",
    "multireach-log check run.lcm",
    "multireach-log cut run.lcm -o part.lcm --from 4 --until 5",
    "multireach-log filter run.lcm -o joints.lcm --channel 'JOINT_*' ROBOT_STATE",
    "multireach-log merge part.lcm joints.lcm -o merged.lcm",
    "multireach-log export csv run.lcm -o tables",
    "multireach-log export mcap run.lcm -o run.mcap",
    "multireach-log images part.lcm -o images",
    "tools/multireach log export csv run.lcm -o tables",
    "multireach-log import MH_01_easy -o session.lcm",
    "multireach-log import pictures -o session.lcm",
    "multireach-log export pairs session.lcm -o pictures",
    "multireach-log export euroc session.lcm -o recording",
    "multireach-log export bag session.lcm -o session.bag",
    "multireach-log check logs/damaged.lcm",
    "tools/multireach replay verify run.lcm",
    "multireach-replay verify logs/load.lcm",
    "tools/multireach replay run logs/reach.lcm -o out.lcm",
    "tools/multireach log report out.lcm --robot robots/hoap2",
    "multireach-replay bisect old.lcm new.lcm",
    "multireach-replay run session.lcm --vision vision.yaml -o out.lcm",
    "multireach-replay sweep session.lcm --set controller.gamma_rad2_m2=100,350 --set tracker.max_process_noise_m2_s3=5,10 -o table.csv",
    "tools/multireach vision --config robots/hoap2/vision.yaml --pair left.png right.png",
    "multireach-vision --config vision.yaml --pair left.png right.png",
    "tools/multireach trace --urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand --law guarded --start=0.2,-0.3,-0.2,-0.9 "
    "--target=0.1,-0.12,0.1 --gamma 350 --steps 300",
    "tools/multireach key new my.key && tools/launch.sh --key my.key",
    "build/release/bin/multireach-figures fig13 --urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand -o curves.csv --measures -",
    "multireach-replay run logs/reach.lcm -o out.lcm",
    "tools/multireach log report run.lcm --robot robots/hoap2",
    "tools/multireach replay sweep logs/reach.lcm --set controller.gamma_rad2_m2=100,180,350 -o table.csv",
    "tools/multireach study --urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand --samples 20000 --csv -",
    "multireach-study --urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand --law guarded --gamma 100,350 --samples "
    "20000 --json study.json",
    "build/release/bin/multireach-figures protocol-reaches --urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand -o "
    "curves.csv --measures -",
]
# Exit codes other than 0, and a part that is left out.
EXPECTED = {"multireach-log check run.lcm": 1, "multireach-log check logs/damaged.lcm": 1}
ONLY_THE_FIRST = {"tools/multireach key new my.key && tools/launch.sh --key my.key"}

# Commands of others: why they are not run here.
OTHERS = {
    "apt": "installs on this computer; tests/full/debian_package.sh does it in a clean system",
    "podman": "no container engine here; tests/full/debian_package.sh runs the steps of the Containerfile",
    "cmake": "tests/package/run.sh installs into a folder of its own",
    "g++": "tests/package/run.sh compiles with the same flags",
    "ctest": "runs these tests",
    "ninja": "builds",
    "lcm-gen": "the build runs it",
    "lcm-logger": "runs until it is ended; every test that records runs it",
    "lcm-logplayer": "plays for as long as the recording; tests/live/sessions.sh runs it",
    "ssh": "needs a second computer; what it runs there is checked",
    "parallel": "needs many processors; tests/full/many_machines.sh runs it",
    "scontrol": "Slurm; tests/full/many_machines.sh runs it",
    "[": "of a script for Slurm",
    "systemctl": "needs a computer that systemd has started; tests/live/systemd_units.sh checks the units",
    "journalctl": "as systemctl",
    "export": "the shell's",
    "kill": "the shell's",
    "cp": "tests/live/new_arm.sh does these steps",
    "rm": "tests/live/new_arm.sh does these steps",
    "mkdir": "the shell's", "cd": "the shell's", "git": "no network here",
}
# Files with these folders at their start exist; names in capitals stand for the reader's own.
FOLDERS = ("robots/", "logs/", "examples/", "docs/", "lcmtypes/", "tests/", "bench/", "studies/")


def all_commands():
    return [command for page in page_names() if not GENERATED.fullmatch(page) for code in code_of(page) if code.language in ("", "sh")
            for command in commands_of(code)]


COMMANDS = all_commands()
SCRIPTS = {"multireach-launch": "tools/launch.sh", "multireach-doctor": "tools/doctor.sh", "multireach-spy": "tools/spy.sh"}


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


@pytest.fixture
def inputs(bin_folder, tmp_path):
    """A folder with what the commands of RUN read."""
    for name in ("robots", "logs", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "tools").mkdir()
    for name in ("multireach", "location.sh", "setup.sh"):  # copies: they run the programs of this folder's build/
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    (tmp_path / "build/release").mkdir(parents=True)
    (tmp_path / "build/release/bin").symlink_to(bin_folder)
    shutil.copy(ROOT / "logs/load.lcm", tmp_path / "run.lcm")
    shutil.copy(ROOT / "robots/hoap2/vision.yaml", tmp_path)

    def call(*words):
        subprocess.run([bin_folder / words[0], *words[1:]], cwd=tmp_path, check=True, capture_output=True)

    call("multireach-log", "cut", "logs/reach.lcm", "-o", "second.lcm", "--until", "1")
    call("multireach-log", "images", "second.lcm", "-o", "pictures", "--channel", "STEREO_IMAGES")
    call("multireach-log", "export", "euroc", "second.lcm", "-o", "MH_01_easy")
    pairs = sorted(path.name for path in (tmp_path / "pictures").glob("*_left.png"))
    (tmp_path / "pictures/pairs.csv").write_text("time_s,left,right\n" + "".join(
        f"{1000 + k / 30:.6f},{name},{name.replace('left', 'right')}\n" for k, name in enumerate(pairs)))
    for side in ("left", "right"):
        shutil.copy(tmp_path / f"pictures/000000_{side}.png", tmp_path / f"{side}.png")
    for name in ("old.lcm", "new.lcm"):
        call("multireach-replay", "run", "second.lcm", "--robot", "robots/hoap2", "-o", name)
    return tmp_path


def test_commands_run_as_written(bin_folder, inputs):
    texts = {command.text for command in COMMANDS}
    assert not set(RUN) - texts, "no page has these commands: RUN in tests/pages/test_commands.py is not current"
    lines = []
    for command in RUN:
        text = command.split(" && ")[0] if command in ONLY_THE_FIRST else command
        lines.append(f"{{ {text}; }} </dev/null >said 2>&1; [ $? -eq {EXPECTED.get(command, 0)} ] || {{ echo FAILED: {shlex.quote(text)}; cat said; }}")
    path = f"{bin_folder}{os.pathsep}{os.environ['PATH']}"
    done = run_isolated(f'cd "$1"; PATH="$2"; export PATH\n' + "\n".join(lines), inputs, path, timeout=500)
    assert done.returncode == 0 and "FAILED" not in done.stdout, done.stdout + done.stderr

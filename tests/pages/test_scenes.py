"""Every command of every page is run: here, in a scene; or by another test, which is named; or it is said why not (command_scenes.py)."""
import json
import pathlib
import re
import shutil
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import script_text
from command_scenes import ELSEWHERE, NOT_RUN, SCENES
from inputs import is_there, make_folder, write_inputs
from namespace import run_isolated
from page_text import ROOT, Command, all_commands
from scenes import Given, Run, Scene, commands_of, play
from test_commands import behind_a_wrapper, own_program, parsed_help

SIDE_BY_SIDE = 3  # scenes; most of them wait


def faults_of_account(commands, run, elsewhere, not_run):
    """Commands of pages that nobody runs, and what no page has."""
    places = {}
    for command in commands:
        places.setdefault(command.text, f"{command.page}:{command.line}")
    kinds = {"a scene": set(run), "ELSEWHERE": set(elsewhere), "NOT_RUN": set(not_run)}
    for text, place in places.items():
        holders = [name for name, texts in kinds.items() if text in texts]
        if not holders:
            yield f"{place}: no test runs `{text}`: it belongs into a scene of tests/pages/command_scenes.py, or into ELSEWHERE or NOT_RUN there"
        elif len(holders) > 1:
            yield f"{place}: `{text}` is in {' and in '.join(holders)}"
    for name, texts in kinds.items():
        yield from (f"no page has `{text}`, which is in {name}" for text in sorted(texts - places.keys()))
    yield from (f"NOT_RUN has no reason for `{text}`" for text, reason in not_run.items() if len(reason.split()) < 3)


def wanted(words, bin_folder):
    """The name of the program that the words start, and what a script must have to run the same: options, subcommand."""
    own = own_program(words, bin_folder)
    if own is None and behind_a_wrapper(words):
        return wanted(behind_a_wrapper(words), bin_folder)
    flags = [word.split("=")[0] for word in words[1:] if re.match(r"--?[A-Za-z]", word)]
    if own is None:
        return words[0], flags + [word for word in words[1:2] if re.fullmatch(r"[a-z]+", word)]
    program, arguments = own
    if program.suffix in (".sh", ".py"):
        return program.name, flags + [word for word in arguments if program.name == "setup.sh" and not word.startswith("-")]
    parsed, chosen = parsed_help(program), []
    for word in arguments:
        if word in parsed.subcommands:
            parsed = parsed.subcommands[word]
            chosen.append(word)
    return program.name, flags + chosen


def faults_of_elsewhere(text, path, bin_folder, root=ROOT):
    """Why the last file of the path does not run the command, or one of them not the next."""
    for before, after in zip(path, path[1:]):
        if not script_text.has_word(script_text.whole_text(root / before), after):
            yield f"{before} does not use {after}, by which it is to run `{text}`"
    body = script_text.whole_text(root / path[-1])
    for words in Command("", 0, text).simple_commands():
        program, needed = wanted(words, bin_folder)
        if program != "[" and not script_text.runs(body, program, needed):
            yield f"{path[-1]} does not run {program} with {' '.join(needed) or 'its name'}, as `{text}` does"


def test_every_command_is_run():
    faults = list(faults_of_account(all_commands(), commands_of(SCENES), ELSEWHERE, NOT_RUN))
    assert not faults, "\n".join(faults)


def test_other_tests_run_what_is_said_of_them(bin_folder):
    faults = [fault for text, path in ELSEWHERE.items() for fault in faults_of_elsewhere(text, path, bin_folder)]
    assert not faults, "\n".join(faults)


@pytest.fixture(scope="session")
def played(request, bin_folder, tmp_path_factory):
    """For each scene that was chosen, what is wrong with it and how long it took; None where something that it needs is not here."""
    base = tmp_path_factory.mktemp("scenes")
    chosen = {item.callspec.params["scene"].name for item in request.session.items if "scene" in getattr(item, "fixturenames", ()) and hasattr(item, "callspec")}
    inputs = base / "inputs"
    inputs.mkdir()
    write_inputs(inputs, bin_folder)

    def play_one(scene):
        if not all(is_there(need, bin_folder) for need in scene.needs):
            return None
        begin, folder = time.monotonic(), base / scene.name.replace(" ", "_")
        environment = make_folder(folder, inputs, bin_folder)
        done = run_isolated(pathlib.Path(__file__).with_name("play_scene.py"), scene.name, folder, timeout=600, environment=environment)
        shutil.rmtree(folder)
        return (json.loads(done.stdout) if done.returncode == 0 else [done.stdout + done.stderr]), time.monotonic() - begin

    chosen_scenes = [scene for scene in SCENES if scene.name in chosen]
    results = {scene.name: play_one(scene) for scene in chosen_scenes if scene.alone}
    others = [scene for scene in chosen_scenes if not scene.alone]
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        results.update(zip([scene.name for scene in others], pool.map(play_one, others)))
    shutil.rmtree(base)
    return results


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_scene(scene, played):
    if played[scene.name] is None:
        pytest.skip(f"one of these is not here: {', '.join(scene.needs)}")
    faults, seconds = played[scene.name]
    print(f"{seconds:.1f} s")
    assert not faults, "\n".join(faults)


# The checker itself, with pages and scripts that are made up.
PAGE = [Command("docs/page.md", 3, "multireach-log info run.lcm"), Command("docs/page.md", 4, "tools/doctor.sh")]


@pytest.mark.parametrize("run, elsewhere, not_run, fault", [
    (["multireach-log info run.lcm"], {}, {}, "docs/page.md:4: no test runs `tools/doctor.sh`"),
    (["multireach-log info run.lcm", "x"], {"tools/doctor.sh": ()}, {}, "no page has `x`, which is in a scene"),
    (["multireach-log info run.lcm"], {"tools/doctor.sh": (), "y": ()}, {}, "no page has `y`, which is in ELSEWHERE"),
    (["multireach-log info run.lcm"], {}, {"tools/doctor.sh": "because it is so", "z": "because it is so"}, "no page has `z`, which is in NOT_RUN"),
    (["multireach-log info run.lcm", "tools/doctor.sh"], {"tools/doctor.sh": ()}, {}, "`tools/doctor.sh` is in a scene and in ELSEWHERE"),
    (["multireach-log info run.lcm"], {}, {"tools/doctor.sh": ""}, "NOT_RUN has no reason for `tools/doctor.sh`"),
])
def test_what_is_wrong_with_the_account_is_found(run, elsewhere, not_run, fault):
    found = list(faults_of_account(PAGE, run, elsewhere, not_run))
    assert len(found) == 1 and fault in found[0]


SCRIPT = """#!/usr/bin/env bash
. "$(dirname "$0")/helper.sh"
tool="$bin/multireach-log"
study=("$bin/multireach-study" --urdf x.urdf --base a)
# multireach-log report is not run here
$tool cut in.lcm -o out.lcm \\
  --from 3
twice() { "${study[@]}" --samples 3 "$@"; }
twice --seed 2
started --record run.lcm
"$bin/multireach-replay" run in.lcm
"""
HELPER = "started() {\n  ../tools/launch.sh --json report.json\n}\n"


@pytest.mark.parametrize("text, fault", [
    ("multireach-log cut run.lcm -o part.lcm --from 4", None),
    ("multireach-study --urdf robot.urdf --samples 7 --seed 1", None),
    ("tools/launch.sh --record other.lcm --json other.json", None),
    ("multireach-log cut run.lcm -o part.lcm --until 4", "script.sh does not run multireach-log with -o --until cut"),
    ("multireach-log report run.lcm", "script.sh does not run multireach-log with report"),
    ("multireach-study --urdf robot.urdf --threads 7", "script.sh does not run multireach-study with --urdf --threads"),
    ("tools/launch.sh --view", "script.sh does not run launch.sh with --view"),
    ("tools/doctor.sh", "script.sh does not run doctor.sh with its name"),
    ("multireach-replay run x.lcm --record", "script.sh does not run multireach-replay with --record run"),
])
def test_what_a_script_runs(bin_folder, tmp_path, text, fault):
    (tmp_path / "script.sh").write_text(SCRIPT)
    (tmp_path / "helper.sh").write_text(HELPER)
    found = list(faults_of_elsewhere(text, ("script.sh",), bin_folder, tmp_path))
    assert [] == found if fault is None else len(found) == 1 and fault in found[0]


def test_a_script_that_does_not_use_the_next(bin_folder, tmp_path):
    (tmp_path / "script.sh").write_text(SCRIPT)
    (tmp_path / "helper.sh").write_text(HELPER)
    (tmp_path / "other.sh").write_text("multireach-log info run.lcm\n")
    assert list(faults_of_elsewhere("multireach-log info x.lcm", ("script.sh", "other.sh"), bin_folder, tmp_path)) == [
        "script.sh does not use other.sh, by which it is to run `multireach-log info x.lcm`"]


@pytest.mark.parametrize("steps, fault", [
    ((Run("echo 3"), Run("test -e made", code=1), Given("touch made"), Run("test -e made")), None),
    ((Run("false"),), "false: exit code 1, expected 0"),
    ((Run("echo one", says="two"),), "echo one: does not say 'two'"),
    ((Run("echo begun; exit 3", ready="ready"),), "ended with code 3 before it was ready"),
    ((Run("trap 'exit 0' INT; echo ready; while :; do sleep 0.1; done &", ready="ready"), Run("true")), None),
    ((Run("trap 'exit 4' INT; echo ready; while :; do sleep 0.1; done", ready="ready"),), "exit code 4, expected 0"),
    ((Run("trap 'touch made; exit 0' INT; echo ready; while :; do sleep 0.1; done &", ready="ready"), Run("test -e made", code=1),
      Run("kill -INT %1", ends="trap 'touch made; exit 0' INT; echo ready; while :; do sleep 0.1; done &"), Run("test -e made")), None),
    ((Run("cat NAME", stands_for={"NAME": "none"}),), "cat NAME: exit code 1"),
    ((Given("false"),), "false: exit code 1"),
])
def test_a_scene_with_a_fault(tmp_path, steps, fault):
    found = play(Scene("made up", steps), tmp_path)
    assert found == [] if fault is None else len(found) == 1 and fault in found[0]


def test_a_program_that_does_not_become_ready_or_end(tmp_path, monkeypatch):
    import scenes
    for name in ("START_S", "RUN_S", "END_S"):
        monkeypatch.setattr(scenes, name, 0.5)
    for step, fault in ((Run("sleep 9", ready="never"), "was not ready after 0.5 s"), (Run("sleep 9"), "ran on for 0.5 s"),
                        (Run("trap '' INT; echo ready; while :; do sleep 1; done", ready="ready"), "ran on for 0.5 s")):
        found = play(Scene("made up", (step,)), tmp_path)
        assert len(found) == 1 and fault in found[0], step

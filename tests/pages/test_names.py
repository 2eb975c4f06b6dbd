"""What the pages name exists: tests, files, channels, keys, classes and functions."""
import re

import pytest

from page_text import GENERATED, ROOT, code_of, page_names, project_files

CODE = {".cpp", ".hpp", ".py", ".pyi", ".sh", ".ts", ".js", ".lcm", ".yaml", ".cmake", ".txt", ".urdf", ".json", ".html", ".css", ".in", ""}
# Names of others, and of files that the reader makes.
FOREIGN = {
    "exposure_dynamic_framerate", "RLIMIT_RTPRIO", "RLIMIT_MEMLOCK", "CAP_SYS_NICE", "PREEMPT_RT", "kuka-driver/sunrise_1.14", "robots/fr3/inertials.yaml",
    "kuka_driver.cc", "franka_driver.cc", "iiwa_constants.cc", "gt1.mat", "shard12.json.progress",
    "vision_error_mm_median",  # of the sweep's table, which puts it together
}


@pytest.fixture(scope="module")
def project():
    files = project_files(ROOT)
    words, tests = set(), set()
    for name in files:
        path = ROOT / name
        words.add(path.name.partition(".")[0])
        if path.suffix in CODE and path.stat().st_size < 2_000_000 and b"\0" not in (data := path.read_bytes()):
            text = data.decode(errors="replace")
            words.update(re.findall(r"\w+", text))
            if name.startswith("tests/"):
                tests.update(f"{suite}.{test}" for suite, test in re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text))
                tests.update(f"{suite}." for suite in re.findall(r"INSTANTIATE_TEST_SUITE_P\(\s*(\w+),", text))
    return files, words, tests


def names_in_sentences():
    for page in page_names():
        if not GENERATED.fullmatch(page) and page != "CHANGELOG.md":
            yield from (code for code in code_of(page) if code.language is None)


def faults_of(code, project):
    """What the code in a sentence names that does not exist."""
    files, words, tests = project
    text = code.text
    if text in FOREIGN:
        return
    if re.fullmatch(r"[A-Z]\w+\.([A-Z]\w*|\*)", text) and not text.startswith(("README.", "CHANGELOG.")):  # a test, or all of a suite
        suite, _, test = text.partition(".")
        if text in tests or any(each.startswith(suite + ".") for each in tests) and (test == "*" or f"{suite}." in tests):
            return
        yield f"there is no test {text}"
    elif re.fullmatch(r"[A-Z]\w+\.([A-Z]\w*)?…", text):  # tests whose names begin so
        if not any(test.startswith(text[:-1]) for test in tests):
            yield f"there is no test {text}"
    elif re.fullmatch(r"[\w.-]+(/[\w.*-]+)+\.\w{2,4}", text) and not re.search(r"[A-Z]{2}|\*", text):  # a file in a folder
        folder = code.page.rpartition("/")[0]
        known = {text, f"{folder}/{text}", f"docs/{text}"} & set(files) or any(name.endswith("/" + text) for name in files)
        if not known and text.split("/")[0] not in ("build", "mav0", "cam0", "its"):
            yield f"there is no file {text}"
    elif re.fullmatch(r"[A-Z][A-Z0-9]+(_[A-Z0-9]+)+|[a-z][a-z0-9]*(_[a-z0-9]+)+(\(\))?|[A-Z]\w+::\w+(\(\))?|[a-z]\w+(\.[a-z]\w+)+(\[\d\])?(\.\w+)?", text):
        missing = [word for word in re.findall(r"[A-Za-z_]\w*", text) if word not in words]
        if missing and not re.search(r"\.(cpp|hpp|sh|py|yaml|lcm|md|csv|json|mp4|png|svg|xml|urdf|css|html)$", text):
            yield f"no file of the project has the name {', '.join(missing)}"


def test_names_exist(project):
    faults, count = [], 0
    for code in names_in_sentences():
        count += 1
        faults += [f"{code.page}:{code.line}: `{code.text}`: {fault}" for fault in faults_of(code, project)]
    assert count > 1500
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("text", ["Fuzz.NoSuchTest", "NoSuchSuite.*", "Bridging.NoSuch…", "runtime/no_such_file.hpp", "NO_SUCH_CHANNEL", "no_such_key_m",
                                  "GuardedLaw::no_such_function", "controller.no_such_key"])
def test_a_name_that_does_not_exist_is_found(project, text):
    code = type("Code", (), {"page": "docs/replay.md", "line": 1, "text": text})
    # This file has the names too.
    files, words, tests = project
    known = words - {"NO_SUCH_CHANNEL", "no_such_key_m", "no_such_function", "no_such_key"}
    assert list(faults_of(code, (files, known, tests)))

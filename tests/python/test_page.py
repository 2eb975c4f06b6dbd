"""The Python code of the pages runs, from top to bottom, in a folder with what it names."""
import re
import shutil

import pytest

from namespace import run_isolated

PREAMBLE = """
import multireach
event = next(multireach.Log("run.lcm").events(["STEREO_IMAGES"]))
left, right = multireach.images_of(event.data)
utime = event.message.utime
"""


def blocks_of(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


def test_every_page_with_code_is_here(root):
    assert {page.name for page in (root / "docs").rglob("*.md") if blocks_of(page)} == {"python.md", "tutorial.md"}


@pytest.mark.parametrize("page, count, last", [
    ("python.md", 6, "ball.status, batch.theta.shape, columns['joint_position'].shape"),
    ("tutorial.md", 1, "commands['joint_position'].shape")])
def test_page(root, tmp_path, monkeypatch, page, count, last):
    blocks = blocks_of(root / "docs" / page)
    assert len(blocks) == count
    for folder in ("robots", "logs"):
        (tmp_path / folder).symlink_to(root / folder)
    shutil.copy(root / "logs/load.lcm", tmp_path / "run.lcm")
    script = tmp_path / "page.py"
    script.write_text(PREAMBLE + "\n".join(blocks) + f"\nprint('all held', {last})\n")
    monkeypatch.chdir(tmp_path)
    done = run_isolated(script)
    assert done.returncode == 0 and "all held" in done.stdout, done.stdout + done.stderr

"""The code of docs/python.md runs, from top to bottom, in a folder with what it names."""
import re
import shutil

from namespace import run_isolated

PREAMBLE = """
import multireach
event = next(multireach.Log("run.lcm").events(["STEREO_IMAGES"]))
left, right = multireach.images_of(event.data)
utime = event.message.utime
"""


def test_page(root, tmp_path, monkeypatch):
    blocks = re.findall(r"^```python\n(.*?)^```", (root / "docs/python.md").read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) == 6
    for folder in ("robots", "logs"):
        (tmp_path / folder).symlink_to(root / folder)
    shutil.copy(root / "logs/load.lcm", tmp_path / "run.lcm")
    script = tmp_path / "page.py"
    script.write_text(PREAMBLE + "\n".join(blocks) + "\nprint('all held', ball.status, batch.theta.shape, columns['joint_position'].shape)\n")
    monkeypatch.chdir(tmp_path)
    done = run_isolated(script)
    assert done.returncode == 0 and "all held" in done.stdout, done.stdout + done.stderr

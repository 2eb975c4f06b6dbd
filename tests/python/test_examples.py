"""Every script of examples/python does what it says."""
import json
import re
import shutil
import subprocess
import sys

import pytest

from namespace import run_isolated


def run(root, name, *arguments):
    done = subprocess.run([sys.executable, root / "examples/python" / name, *map(str, arguments)], capture_output=True, text=True,
                          timeout=180)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_reach(root):
    out = run(root, "reach.py", "--robot", root / "robots/hoap2", "--target", "0.1", "-0.12", "0.1")
    assert float(re.search(r"error (\S+) mm", out)[1]) < 0.1
    assert "unreachable" in run(root, "reach.py", "--robot", root / "robots/hoap2", "--target", "0.9", "0", "0")


def test_log_to_plot(root, tmp_path):
    shutil.which("gnuplot") or pytest.skip("gnuplot is not here")
    run(root, "log_to_plot.py", root / "logs/load.lcm", "-o", tmp_path / "plot.svg")
    text = (tmp_path / "plot.svg").read_text()
    assert text.startswith("<?xml") and "right_EB" in text


def test_own_detector(root):
    script = root / "examples/python/own_detector.py"
    done = run_isolated(f'{sys.executable} "$1" --vision "$2" --pairs 60 & sleep 2; '
                        'lcm-logplayer --lcm-url="udpm://239.255.76.68:7668?ttl=0" --speed=1 "$3" >/dev/null & player=$!; wait %1; code=$?; '
                        'kill $player; exit $code', script, root / "robots/hoap2/vision.yaml", root / "logs/reach.lcm")
    assert done.returncode == 0, done.stdout + done.stderr
    found = re.search(r"(\d+) of (\d+) pairs, median error (\S+) mm", done.stdout)
    # A centroid of pixels, blurred and shaded, without the ball's contour: within a tenth of its diameter.
    assert int(found[1]) >= 50 and float(found[3]) < 4, done.stdout


def test_ik_comparison(root):
    out = run(root, "ik_comparison.py", "--robot", root / "robots/hoap2", "--targets", 40)
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines()[1:]}
    assert float(rows["nearest"][0]) == 100 and float(rows["nearest"][0]) >= float(rows["newton"][0])


def test_parameter_sweep(root):
    out = run(root, "parameter_sweep.py", root / "logs/reach.lcm", "--robot", root / "robots/hoap2", "--gamma", "60", "350", "--until",
              "3", "--json")
    rows = json.loads(out)
    assert [row["gamma_rad2_m2"] for row in rows] == [60, 350]
    assert all(row["reached"] >= 1 for row in rows) and rows[0]["path_m"] != rows[1]["path_m"]

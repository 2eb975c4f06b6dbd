"""Runs commands in a network namespace of their own, so that no message leaves the test."""
import os
import subprocess
import sys

import pytest

UNSHARE = ["unshare", *([] if os.getuid() == 0 else ["--map-root-user"]), "--net"]


def run_isolated(script, *arguments, timeout=180, environment=None):
    """Runs a Python script, or shell text; what it did, as of subprocess.run. Skips the test where that is not allowed."""
    if subprocess.run([*UNSHARE, "true"], capture_output=True).returncode != 0:
        pytest.skip("a network namespace cannot be made here")
    network = "ip link set lo up && ip route add 224.0.0.0/4 dev lo && "
    command = f'exec {sys.executable} "$@"' if not isinstance(script, str) else script
    words = [str(word) for word in ((script,) if not isinstance(script, str) else ()) + arguments]
    environment = dict(environment or os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    return subprocess.run([*UNSHARE, "sh", "-c", network + command, "sh", *words], capture_output=True, text=True, timeout=timeout,
                          env=environment)

"""Publishing and subscribing, with the guard against malformed datagrams: bus_check.py in a network namespace."""
import pytest

import multireach
from namespace import run_isolated


def test_bus(root):
    done = run_isolated(root / "tests/python/bus_check.py")
    assert done.returncode == 0 and "all held" in done.stdout, done.stdout + done.stderr


def test_without_a_network_a_sentence_says_what_is_missing():
    with pytest.raises(multireach.InputError, match="LCM cannot be started on 'nonsense://'"):
        multireach.Bus("nonsense://")

"""What all tests of the Python module share. Run by ctest, or: PYTHONPATH=build/release/python /usr/bin/python3 -m pytest tests/python"""
import pathlib

import numpy as np
import pytest

import multireach

ROOT = pathlib.Path(__file__).resolve().parents[2]
SEED = 20081  # printed by every test that fails: pytest shows fixtures


@pytest.fixture
def root():
    return ROOT


@pytest.fixture
def rng():
    print("seed", SEED)
    return np.random.default_rng(SEED)


@pytest.fixture(params=["hoap2", "iiwa14", "panda", "fr3", "so101", "ur5e"])
def any_arm(request):
    return multireach.Chain.from_robot(ROOT / "robots" / request.param), ROOT / "robots" / request.param


@pytest.fixture
def hoap2():
    return multireach.Chain.from_robot(ROOT / "robots/hoap2")


def draw(arm, rng, count):
    """Joint configurations inside the limits, shape (count, n)."""
    return rng.uniform(arm.sample_lower, arm.sample_upper, (count, arm.size))

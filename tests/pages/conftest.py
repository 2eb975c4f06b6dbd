"""What the tests of the pages share. Run by ctest, or: MULTIREACH_BIN=build/release/bin /usr/bin/python3 -m pytest tests/pages"""
import os
import pathlib

import pytest

from page_text import ROOT


@pytest.fixture(scope="session")
def bin_folder():
    return pathlib.Path(os.environ.get("MULTIREACH_BIN", ROOT / "build/release/bin")).resolve()

"""Man pages and completion of a program with a subcommand, made from its --help; bash itself completes."""
import gzip
import subprocess
import sys

import pytest

HELP = """Moves things.
Usage: multireach-mover [OPTIONS] SUBCOMMAND

Options:
  -h,--help                       Print this help message and exit
  --law TEXT:{paper,guarded}=guarded
                                  control law
  --port INT:INT in [0 - 65535]=0 0: any
  --config TEXT REQUIRED          a file
                                  .with a dot at the start of a line

Subcommands:
  push                            pushes
"""
PUSH = """pushes
Usage: multireach-mover push [OPTIONS]

Positionals:
  WHAT TEXT:{box,door} REQUIRED   what to push

Options:
  -h,--help                       Print this help message and exit
  --force FLOAT                   N
"""


@pytest.fixture
def pages(root, tmp_path):
    program = tmp_path / "multireach-mover"
    program.write_text(f"#!/bin/sh\ncase $1 in push) cat <<'EOT'\n{PUSH}EOT\n;; *) cat <<'EOT'\n{HELP}EOT\n;; esac\n")
    program.chmod(0o755)
    subprocess.run([sys.executable, root / "tools/program_pages.py", tmp_path, "1.2", program], check=True)
    return tmp_path


def completed(pages, *words):
    script = (f". {pages}/completions/multireach-mover; COMP_WORDS=(multireach-mover \"$@\"); COMP_CWORD=$#; "
              "compopt() { echo \"compopt $*\"; }; _multireach_mover; echo \"${COMPREPLY[*]}\"")
    return subprocess.run(["bash", "-c", script, "bash", *words], capture_output=True, text=True, check=True).stdout.split()


def test_completion(pages):
    assert completed(pages, "--") == ["--help", "--law", "--port", "--config"]
    assert completed(pages, "pu") == ["push"]
    assert completed(pages, "--law", "") == ["paper", "guarded"]
    assert completed(pages, "--law", "g") == ["guarded"]
    assert completed(pages, "--law", "=", "g") == ["guarded"]
    assert completed(pages, "--law", "=") == ["paper", "guarded"]
    assert completed(pages, "") == ["push"]
    assert completed(pages, "push", "") == ["box", "door"]
    assert completed(pages, "push", "a_file") == ["compopt", "-o", "default"]
    assert completed(pages, "--config", "") == ["compopt", "-o", "default"]
    assert completed(pages, "push", "--") == ["--help", "--force"]


def test_man_page(pages):
    text = gzip.decompress((pages / "man/multireach-mover.1.gz").read_bytes()).decode()
    assert text.startswith(".TH MULTIREACH-MOVER 1") and "multireach-mover \\- Moves things\n" in text
    assert ".B \\-\\-port INT:INT in [0 \\- 65535]=0\n0: any\n" in text  # one space between name and text
    for option in ("\\-\\-law TEXT:{paper,guarded}=guarded", "\\-\\-force FLOAT", ".SS push"):
        assert option in text
    # No word of a help text is an instruction to roff.
    requests = {line.split()[0] for line in text.splitlines() if line.startswith((".", "'"))}
    assert requests <= {".TH", ".SH", ".SS", ".TP", ".B", ".I", ".PP", ".br"}


def test_a_program_that_fails_is_an_error(root, tmp_path):
    done = subprocess.run([sys.executable, root / "tools/program_pages.py", tmp_path, "1.2", "/bin/false"], capture_output=True, text=True)
    assert done.returncode == 1 and "/bin/false --help: exit code 1" in done.stderr

"""What the scripts share that run programs and print tables of docs/ as Markdown."""
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def output_of(*command, expected=0):
    """The standard output of a program, found in PATH; ends the script where the program does not end with the expected exit code."""
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != expected:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: exit code {done.returncode} of: {' '.join(map(str, command))}")
    return done.stdout


def section(title):
    print(f"\n## {title}\n")


def head(*columns):
    print("| " + " | ".join(columns) + " |\n" + "|---" * len(columns) + "|")


def row(*cells):
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def print_chosen(tables, usage):
    """Prints the table that the command line names. The functions of tables take what follows the name."""
    name = pathlib.Path(sys.argv[0]).name
    if sys.argv[1:] in (["--help"], ["-h"]):
        print(usage.strip())
    elif len(sys.argv) < 2 or sys.argv[1] not in tables:
        sys.exit(f"{name}: expected one of: {', '.join(tables)}")
    else:
        tables[sys.argv[1]](*sys.argv[2:])

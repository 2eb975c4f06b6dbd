"""Scenes: commands of the pages, in the order in which a reader gives them, played in a folder and a network of their own.

`play` starts each command by bash. One with `ready` runs until the scene ends it by SIGINT, as Ctrl-C does; it must have said what `ready`
describes, and its exit code counts like that of the others.
"""
import os
import re
import signal
import subprocess
import time
from dataclasses import dataclass, field

START_S, RUN_S, END_S = 60, 180, 30  # until it is ready, until it ends by itself, until it has ended after SIGINT
GROWN_BYTES = 50_000


@dataclass(frozen=True)
class Run:
    """A command of a page, as it stands there."""
    text: str
    code: int = 0
    ready: str = ""    # what its output has when others may follow; "grown:PATTERN": a file that is long then
    says: str = ""     # what its output has in the end
    after_s: float = 0  # how long it runs on when it is ready
    stands_for: dict = field(default_factory=dict)  # what the reader writes for words in capitals, "…" and the like
    environment: dict = field(default_factory=dict)
    ends: str = ""     # the command does no more than to end this one (`kill -INT %1`)


@dataclass(frozen=True)
class Given:
    """What the reader has or does besides: shell text."""
    text: str


@dataclass(frozen=True)
class Scene:
    name: str
    steps: tuple
    needs: tuple = ()   # paths below the root, or programs, without which it is skipped
    alone: bool = False  # beside no other one: a run in real time must pass whole


def commands_of(scenes):
    return [step.text for scene in scenes for step in scene.steps if isinstance(step, Run)]


class Started:
    def __init__(self, step, folder, number):
        text = re.sub(r"\s&$", "", step.text)
        for old, new in step.stands_for.items():
            assert old in text, f"{step.text}: has no '{old}'"
            text = text.replace(old, new)
        self.step, self.output = step, folder / f".said{number}"
        with open(self.output, "w") as output:
            self.process = subprocess.Popen(["bash", "-c", text], cwd=folder, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                            start_new_session=True, env={**os.environ, **step.environment})
        self.folder = folder

    def said(self):
        return self.output.read_text(errors="replace")

    def is_ready(self):
        if self.step.ready.startswith("grown:"):
            return any(path.stat().st_size > GROWN_BYTES for path in self.folder.glob(self.step.ready.removeprefix("grown:")))
        return bool(re.search(self.step.ready, self.said()))

    def await_ready(self):
        end = time.monotonic() + START_S
        while not self.is_ready():
            if self.process.poll() is not None:
                return f"ended with code {self.process.returncode} before it was ready"
            if time.monotonic() > end:
                return f"was not ready after {START_S} s: '{self.step.ready}' is missing"
            time.sleep(0.05)
        time.sleep(self.step.after_s)
        return None

    def await_end(self, seconds):
        """Why its end is not as expected; None if it is."""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return f"ran on for {seconds} s"
        if code != self.step.code:
            return f"exit code {code}, expected {self.step.code}"
        if not re.search(self.step.says, self.said()):
            return f"does not say '{self.step.says}'"
        return None

    def signal(self, number):
        """To its group, as a terminal does."""
        try:
            os.killpg(self.process.pid, number)
        except ProcessLookupError:
            pass

    def interrupt(self):
        if self.process.poll() is None:
            self.signal(signal.SIGINT)
        return self.await_end(END_S)


def play(scene, folder):
    """What is wrong with the commands of a scene."""
    running, faults = [], []

    def found(job, fault):
        if fault:
            faults.append(f"{job.step.text}: {fault}:\n{job.said()[-2000:]}")

    for number, step in enumerate(scene.steps):
        if isinstance(step, Given):
            done = subprocess.run(["bash", "-ec", step.text], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True)
            if done.returncode != 0:
                faults.append(f"{step.text}: exit code {done.returncode}: {done.stdout}{done.stderr}")
        elif step.ends:
            job = next(job for job in running if job.step.text == step.ends)
            running.remove(job)
            found(job, job.interrupt())
        elif step.text.startswith("export "):
            name, _, value = step.text.removeprefix("export ").partition("=")
            os.environ[name] = subprocess.run(["bash", "-c", f"echo {value}"], cwd=folder, capture_output=True, text=True).stdout.strip()
        else:
            job = Started(step, folder, number)
            if step.ready:
                running.append(job)
                found(job, job.await_ready())
            else:
                found(job, job.await_end(RUN_S))
            if job not in running:
                job.signal(signal.SIGKILL)
        if faults:
            break  # what follows would only fail for this reason
    for job in reversed(running):
        if faults:
            job.signal(signal.SIGKILL)
        else:
            found(job, job.interrupt())
            job.signal(signal.SIGKILL)
    return faults

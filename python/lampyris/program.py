"""Runs the program."""

from __future__ import annotations

import os
import shutil
import subprocess


class LampyrisError(RuntimeError):
    """A script or its input failed; the text is the program's one message."""


def run(script: str | os.PathLike, *arguments: str, out: str | os.PathLike | None = None) -> str:
    """Runs a Lua script with arguments, and returns what it prints.

    The program is that of the environment variable LAMPYRIS, or `lampyris` on the PATH.
    Raises LampyrisError with the program's message if the script fails.
    """
    program = os.environ.get("LAMPYRIS") or shutil.which("lampyris")
    if program is None:
        raise LampyrisError("no program: set LAMPYRIS to its path, or put lampyris on the PATH")
    command = [program, "run", os.fspath(script), "--quiet"]
    if out is not None:
        command += ["--out", os.fspath(out)]
    if arguments:
        command += ["--", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise LampyrisError(done.stderr.strip() or f"exit status {done.returncode}")
    return done.stdout

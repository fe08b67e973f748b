"""Exported C on two ARM chips under qemu: its results, and how many instructions a call
executes.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import weakref
from functools import cache
from pathlib import Path

import numpy as np

EMULATOR = "qemu-arm"
# Compiler and flags: a chip whose hardware knows single precision alone (a Cortex-M4F), and one
# that knows double too.
CHIPS = {
    "single": (
        "arm-linux-gnueabi-gcc",
        "-march=armv7-a",
        "-mfloat-abi=softfp",
        "-mfpu=fpv4-sp-d16",
    ),
    "double": ("arm-linux-gnueabihf-gcc", "-march=armv7-a", "-mfpu=vfpv3-d16"),
}
PACKAGES = (
    "gcc-arm-linux-gnueabi libc6-dev-armel-cross gcc-arm-linux-gnueabihf libc6-dev-armhf-cross"
    " qemu-user"
)
FLAGS = "-O2", "-std=c99", "-ffp-contract=off", "-static"
MAIN = """
#include <stdio.h>
#include <stdlib.h>
static fivebar_real in[100000], out[100000];
int main(int words, char **word)
{{
    long times = atol(word[words - 1]);
    long count = (long)fread(in, {inputs} * sizeof in[0], 100000 / {inputs}, stdin);
    while (times--) run(count, in, out);
    return fwrite(out, {outputs} * sizeof out[0], (size_t)count, stdout) != (size_t)count;
}}
"""
COUNTED = 10  # rows of inputs: each instruction that they take is a line of a file


def lacks_arm() -> str | None:
    """What is missing of the compilers and the emulator, None if nothing."""
    wanted = EMULATOR, *(chip[0] for chip in CHIPS.values())
    missing = next((program for program in wanted if not shutil.which(program)), None)
    return f"no {missing}: apt-get install {PACKAGES}" if missing else None


@cache
def _one_by_one():
    """The emulator's option to log each instruction as it comes, which has another name since its
    version 8.
    """
    notes = subprocess.run([EMULATOR, "--help"], capture_output=True, text=True).stdout
    return "-one-insn-per-tb" if "one-insn-per-tb" in notes else "-singlestep"


class OnArm:
    """A program of C with a function run(count, in, out), for one of CHIPS; flags: more of the
    compiler's.
    """

    def __init__(self, text: str, chip: str, inputs: int, outputs: int, flags: tuple = ()) -> None:
        self.folder, self.outputs = Path(tempfile.mkdtemp(prefix="fivebar-arm-")), outputs
        weakref.finalize(self, shutil.rmtree, self.folder)
        source, self.program = (self.folder / name for name in ("model.c", "model"))
        source.write_text(text + MAIN.format(inputs=inputs, outputs=outputs), encoding="utf-8")
        command = [*CHIPS[chip], *FLAGS, *flags, str(source), "-o", str(self.program), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{command[0]} failed: {' '.join(done.stderr.split())[:500]}")

    def results(self, samples: np.ndarray) -> np.ndarray:
        """(n, outputs) of samples (n, inputs), of the precision that was compiled."""
        return np.frombuffer(self._run(samples), dtype=samples.dtype).reshape(-1, self.outputs)

    def executed(self, samples: np.ndarray) -> float:
        """Instructions that a call executes, those of the mathematical library among them: the mean
        over samples.
        """
        few, lines = samples[:COUNTED], []
        log = self.folder / "log"
        for times in (1, 2):
            self._run(few, times, _one_by_one(), "-d", "exec,nochain", "-D", str(log))
            with log.open("rb") as file:
                lines.append(sum(line.startswith(b"Trace") for line in file))
        return (lines[1] - lines[0]) / len(few)

    def _run(self, samples, times=1, *options):
        command = [EMULATOR, *options, str(self.program), str(times)]
        return subprocess.run(
            command, input=samples.tobytes(), capture_output=True, check=True
        ).stdout

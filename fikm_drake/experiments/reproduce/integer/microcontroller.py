"""Paper 5 on a small processor: cycles of the exported C on an ATmega328P, simulated by simavr.

The paper's processor has 16 bits and 25 MHz and takes 175 µs for 4 joints: 4,375 cycles. An AVR has 8 bits
and no division, so the same number of cycles is the harder job. Where `avr-gcc` and `simavr` (Debian:
gcc-avr, avr-libc, simavr) are not installed nothing is measured.
"""

import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fikm_drake.experiments.reproduce.integer.table_2 import TABLE_2, many_joints
from fikm_drake.experiments.reproduce.report import Cell, Section
from fikm_drake.fuzzy.integer import IntegerRuleBase, write_c
from fikm_drake.fuzzy.integer.integer_partition import Rounding
from fikm_drake.fuzzy.integer.integer_rule_base import Conjunction
from fikm_drake.fuzzy.integer.write_c import Shape

MCU, CLOCK = "atmega328p", 16_000_000
"""Processor and clock of the simulation [Hz]; cycles do not depend on it."""
PAPERS_CLOCK = 25
"""Clock of the paper's processor [MHz]."""
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", f"-mmcu={MCU}", f"-DF_CPU={CLOCK}UL")
EVERY = 50
"""Points of the workplane [mm]."""
TIMEOUT = 120.0
"""For one simulation [s]."""
DRIVER = """\
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdio.h>
#include "rules.h"

static int put(char c, FILE *stream)
{
    (void)stream;
    while (!(UCSR0A & _BV(UDRE0)))
        ;
    UDR0 = c;
    return 0;
}

static FILE out = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);

int main(void)
{
    int32_t x, y, outputs[RULES_OUTPUTS];
    uint16_t idle, cycles;
    unsigned k;

    UCSR0B = _BV(TXEN0);
    TCCR1A = 0;
    TCCR1B = _BV(CS10); /* timer 1 counts every cycle */
    TCNT1 = 0;
    idle = TCNT1; /* what reading the timer costs */
    for (x = X_LOW; x <= X_HIGH; x += EVERY)
        for (y = Y_LOW; y <= Y_HIGH; y += EVERY) {
            TCNT1 = 0;
            rules_infer(x, y, outputs);
            cycles = TCNT1 - idle;
            fprintf(&out, "=%u", cycles);
            for (k = 0; k < RULES_OUTPUTS; k++)
                fprintf(&out, " %ld", (long)outputs[k]);
            put('\\n', &out);
        }
    cli();
    sleep_mode();
    return 0;
}
"""
"""Prints the cycles of each call and what it infers; simavr ends when the processor sleeps for good."""
VARIANTS: tuple[tuple[str, int, int, Conjunction, Rounding, Shape], ...] = (
    ("3 x 3, min, cut off", 4, 3, "min", "truncate", "shared_cell"),
    ("3 x 3, min, cut off, rule loop", 4, 3, "min", "truncate", "rule_loop"),
    ("9 x 9, product, rounded", 4, 9, "product", "nearest", "shared_cell"),
    ("3 x 3, min, cut off", 24, 3, "min", "truncate", "shared_cell"),
)
"""What is measured: name, joints, labels of x and of y, AND, rounding, shape of the C."""


@dataclass(frozen=True)
class AvrRun:
    """Calls on a grid of inputs."""

    cycles: np.ndarray
    """(N,) of each call."""
    mismatches: int
    """Integers that differ from Python's."""
    flash: int
    """Bytes of code and tables of the rules."""


def missing_tools() -> list[str]:
    """Programs that are not installed."""
    return [tool for tool in ("avr-gcc", "avr-size", "simavr") if shutil.which(tool) is None]


def run_on_avr(rules: IntegerRuleBase, shape: Shape, *, every: int = EVERY) -> AvrRun:
    """Compile the C of rules for the AVR, and run it in the simulator on a grid.

    Args:
        rules: their tables must fit 2 kB, the processor's memory.
        shape: of the C.
        every: distance of neighbouring inputs.

    Raises:
        RuntimeError: a tool is missing or fails; the message has its output.
    """
    if missing_tools():
        raise RuntimeError(f"not installed: {', '.join(missing_tools())}")
    with TemporaryDirectory() as name:
        folder = Path(name)
        source, _ = write_c(rules, folder / "rules.c", shape=shape)
        (folder / "driver.c").write_text(DRIVER, encoding="utf-8")
        x, y = rules.first, rules.second
        limits = {"X_LOW": x.low, "X_HIGH": x.high, "Y_LOW": y.low, "Y_HIGH": y.high}
        defines = [f"-D{key}={value}L" for key, value in (limits | {"EVERY": every}).items()]
        program = folder / "program.elf"
        _run(["avr-gcc", *FLAGS, "-c", str(source), "-o", str(folder / "rules.o")])
        sizes = _run(["avr-size", "-A", str(folder / "rules.o")])
        files = [str(folder / "driver.c"), str(folder / "rules.o")]
        _run(["avr-gcc", *FLAGS, *defines, *files, "-o", str(program)])
        text = _run(["simavr", "-m", MCU, "-f", str(CLOCK), str(program)])
    rows = [list(map(int, line.split())) for line in re.findall(r"=(\d+(?: -?\d+)+)", text)]
    table = np.array(rows)
    xs, ys = (np.arange(p.low, p.high + 1, every) for p in (x, y))
    expected, _ = rules.infer_batch(*np.meshgrid(xs, ys, indexing="ij"))
    wanted = expected.reshape(-1, rules.num_outputs)
    if table.shape != (len(wanted), 1 + rules.num_outputs):
        raise RuntimeError(f"simavr printed {len(rows)} of {len(wanted)} results: {text[-500:]}")
    parts = re.findall(r"^\.(?:text|data|rodata|bss)\S*\s+(\d+)", sizes, flags=re.M)
    return AvrRun(table[:, 0], int((table[:, 1:] != wanted).sum()), sum(map(int, parts)))


def mcu() -> Section:
    """Cycles on a microcontroller of 8 bits, beside the paper's of 16."""
    title = f"cycles of one call on an {MCU}, simulated"
    if missing_tools():
        note = f"Skipped: {', '.join(missing_tools())} not installed (Debian: gcc-avr avr-libc simavr)."
        return Section("mcu", title, [], [note])
    cells = []
    for name, joints, labels, conjunction, rounding, shape in VARIANTS:
        rules = many_joints(
            joints, labels=(labels, labels), conjunction=conjunction, rounding=rounding
        )
        run = run_on_avr(rules, shape)
        paper = TABLE_2[joints] * PAPERS_CLOCK if labels == 3 else None
        label = f"{joints} joints, {name}"
        most = int(run.cycles.max())
        claim = most <= paper if paper is not None and shape == "shared_cell" else None
        cells += [
            Cell(f"{label}: cycles, at most", paper, most, claim),
            Cell(f"{label}: cycles, mean", None, float(run.cycles.mean())),
            Cell(f"{label}: time at 16 MHz [µs]", None, most / (CLOCK / 1e6)),
            Cell(f"{label}: bytes of code and tables", None, run.flash),
            Cell(
                f"{label}: integers that differ from Python's",
                None,
                run.mismatches,
                not run.mismatches,
            ),
        ]
    notes = [
        f"The paper: times of Table 2 at {PAPERS_CLOCK} MHz, on a processor of 16 bits; the AVR has 8",
        "and no division. Grades have 16 bits, sums 32, and a quotient of 16 bits is divided bit by bit.",
        f"Inputs every {EVERY} mm; cycles by the processor's timer, its reading subtracted.",
    ]
    return Section("mcu", title, cells, notes)


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, timeout=TIMEOUT)
    text = (done.stdout + done.stderr).decode("utf-8", "replace")
    if done.returncode:
        raise RuntimeError(f"{command[0]} failed: {text}")
    return text

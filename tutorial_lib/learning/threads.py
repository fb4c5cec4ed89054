"""How many threads networks use: one, unless the user chose a number.

The networks are small. torch uses as many threads as there are cores, and on a machine that does
other work besides these mostly wait for each other: a step of a car takes 60 ms and not 3.
"""

import ctypes
import os
from functools import cache
from pathlib import Path

import torch

from tutorial_lib.validation import whole

_AT_IMPORT = torch.get_num_threads()
_FAMILY = ("vendor_id", "cpu family", "model")
_MOST = 4096
"""Far more than processors have; torch takes any number, and the process ends at its first sum."""


def use_threads(count: int) -> None:
    """Let networks use that many threads in this process, from 1 to 4,096.

    Raises:
        InputError: when it is another number.
    """
    count = whole("count", count, least=1, most=_MOST)
    settle_threads()  # else the first network would set its own number
    torch.set_num_threads(count)


@cache
def settle_threads() -> None:
    """Set one thread in this process, once, when its first network comes.

    A user's own number stays: that of `OMP_NUM_THREADS` or `MKL_NUM_THREADS`, or of
    `torch.set_num_threads`, called before or after.
    """
    by_environment = any(os.environ.get(name) for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"))
    if not by_environment and torch.get_num_threads() == _AT_IMPORT and not _told_mkl():
        torch.set_num_threads(1)


def _told_mkl() -> int:
    """The number that torch told MKL: 0 unless it was set in this thread.

    torch does not say whether its number was set or is its own, and MKL does. Where there is no MKL
    it is 0, and a number that was set before this module was imported is not noticed.
    """
    try:
        folder = Path(torch.__file__).parent / "lib"
        library = ctypes.CDLL(str(folder / "libtorch_cpu.so"))
        told: int = library.MKL_Set_Num_Threads_Local(0)
        library.MKL_Set_Num_Threads_Local(told)
    except (OSError, AttributeError):
        return 0
    return told


def processor() -> str:
    """The kind of processor that torch computes for, as AVX2 or AVX512; on Linux also its family.

    From one kind to another the last digits of a network's outputs differ.
    """
    kinds = [torch.backends.cpu.get_cpu_capability()]
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8").partition("\n\n")[0]
    except OSError:
        return kinds[0]
    lines = dict(line.split("\t", 1) for line in first.splitlines() if "\t" in line)
    kinds += [lines[name].strip("\t: ") for name in _FAMILY if name in lines]
    return " ".join(kinds)

"""Says what is being done, and is never silent for long."""

from __future__ import annotations

import time
from contextlib import suppress
from threading import Event, Thread
from types import TracebackType

QUIET = 4.0
"""Seconds after which a word is said of work that still goes on."""


class Narrator:
    """Prints what is being done, with the seconds since the beginning; a context manager."""

    def __init__(self) -> None:
        self._begun = self._said = time.monotonic()
        self._doing = ""
        self._over = Event()
        self._thread = Thread(target=self._keep_talking, daemon=True)

    def __enter__(self) -> Narrator:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        self._thread.join()

    def __call__(self, text: str) -> None:
        """Say what is being done from now on."""
        self._doing = text.partition(":")[0]
        self._print(text)

    def _keep_talking(self) -> None:
        while not self._over.wait(max(0.0, self._said + QUIET - time.monotonic())):
            if time.monotonic() - self._said >= QUIET:
                with suppress(BrokenPipeError):  # which the next word of the work itself meets
                    self._print(f"still {self._doing}")

    def _print(self, text: str) -> None:
        self._said = time.monotonic()
        print(f"{self._said - self._begun:5.1f} s  {text}", flush=True)

import sys
import threading
import time

import numpy as np
import pytest

from tutorial_lib.checks.framework import guard
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare


@check(lambda x: x, (1.0,))
def check_identity(student):
    """It gives back what it got."""
    compare("identity", student, {"two": (2.0,)}, lambda x: x, {})


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(guard, "SECONDS", 0.3)
    monkeypatch.setattr(guard, "WAITING", 0.8)


def endless(x):
    while True:
        pass


def endless_and_deaf(x):
    while True:
        try:  # noqa: SIM105
            time.sleep(0.001)
        except:  # noqa: E722 - as a student writes it
            pass


def asleep(x):
    time.sleep(60)


@pytest.mark.parametrize("student", [endless, endless_and_deaf, asleep])
def test_a_function_that_never_ends_is_ended(student):
    begun = time.monotonic()
    result = check_identity(student)
    assert result.status == "failed"
    assert "0.3 seconds" in result.message
    assert "loop" in result.message
    assert time.monotonic() - begun < 10


@pytest.mark.parametrize("package", ["numba", "matplotlib"])
def test_a_kernel_is_compiled_and_a_package_imported_to_the_end(package):
    kernels = {"__name__": f"{package}.some.module", "time": time, "ends": time.monotonic() + 1.2}
    exec("def compiled(x):\n    while time.monotonic() < ends: pass\n    return x", kernels)
    compiled = []

    def slow_once(x):
        compiled.append(kernels["compiled"](x))
        endless(x)

    assert "0.3 seconds" in check_identity(slow_once).message
    assert compiled == [2.0]


def test_also_where_signals_do_not_reach():
    results = []
    thread = threading.Thread(target=lambda: results.append(check_identity(endless)))
    thread.start()
    thread.join(20)
    assert "0.3 seconds" in results[0].message


def test_on_a_crowded_machine_a_function_that_computes_is_waited_for(monkeypatch):
    monkeypatch.setattr(guard, "SECONDS", 20.0)

    def slow(x):
        end = time.process_time() + 2 * guard.WAITING
        while time.process_time() < end:
            pass
        return x

    results = [check_identity(slow)]
    thread = threading.Thread(target=lambda: results.append(check_identity(slow)))
    thread.start()
    thread.join(20)
    assert [result.status for result in results] == ["passed", "passed"]


def test_after_a_check_no_limit_is_left():
    def debugger(*_):
        return None

    before = sys.gettrace()
    sys.settrace(debugger)
    try:
        check_identity(lambda x: x)
        assert sys.gettrace() is debugger
    finally:
        sys.settrace(before)
    time.sleep(1.0)  # an alarm that still rings would raise here


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_a_loop_that_fills_the_memory_is_reported(monkeypatch):
    monkeypatch.setattr(guard, "SECONDS", 20.0)
    monkeypatch.setattr(guard, "WAITING", 40.0)
    monkeypatch.setattr(guard, "MEMORY", 2e8)

    def greedy(x):
        kept = [np.ones(1)]
        while True:
            kept.append(np.ones(10_000_000))

    result = check_identity(greedy)
    assert result.status == "failed"
    assert "memory" in result.message
    assert np.ones(30_000_000).sum() == 30_000_000  # the limit is gone


def test_the_end_of_the_program_is_reported():
    result = check_identity(lambda x: sys.exit())
    assert result.status == "failed"
    assert "sys.exit" in result.message


def test_the_student_may_interrupt_a_check():
    def interrupted(x):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        check_identity(interrupted)


def test_endless_output_is_cut(capsys):
    def loud(x):
        for _ in range(100):
            print("x" * 1_000)
        return x

    assert check_identity(loud).status == "passed"
    printed = capsys.readouterr().out
    assert guard.PRINTED <= len(printed) < guard.PRINTED + 100
    assert "only the first" in printed


def test_an_error_is_reported_with_its_line():
    def divides(x):
        return x / 0

    message = check_identity(divides).message
    assert "ZeroDivisionError" in message
    assert "return x / 0" in message


def test_words_of_its_own_for_a_loop_that_never_ends():
    @check(lambda x: x, (1.0,), endless="count down, not up ({seconds:g} s)")
    def check_countdown(student):
        """It ends."""
        student(2.0)

    assert check_countdown(endless).message == "count down, not up (0.3 s)"

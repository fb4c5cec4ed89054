"""Checks of students' answers."""

TESTS = "checks/test_checks.py"
MUTATIONS = [
    (
        "large answers may be a little wrong",
        "checks/framework/comparison.py",
        "atol=tolerance, rtol=0, equal_nan",
        "atol=tolerance, equal_nan",
        f"{TESTS} -k 'messages or slow or limit or as_right_as'",
    ),
    (
        "a slow solution is used, a fast one is not",
        "checks/framework/check.py",
        "if ratio <= SLOWEST else",
        "if ratio >= SLOWEST else",
        f"{TESTS} -k 'messages or slow or limit or as_right_as'",
    ),
    (
        "a debugger is gone after a check",
        "checks/framework/timeout.py",
        "sys.settrace(before)",
        "sys.settrace(None)",
        f"{TESTS} -k 'messages or slow or limit or as_right_as'",
    ),
    (
        "a mistake that explains one answer is named for all",
        "checks/framework/comparison.py",
        "return all(same(one, other, *case)",
        "return any(same(one, other, *case)",
        f"{TESTS} -k message_of_its_own",
    ),
    (
        "a probability that is a little off passes",
        "checks/nb06/most_probable_path.py",
        "isclose(got[1], want[1], abs_tol=1e-9)",
        "isclose(got[1], want[1], abs_tol=1e-2)",
        f"{TESTS} -k 'message_of_its_own or little_off'",
    ),
]

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
        "if ratio <= SLOWEST or",
        "if ratio >= SLOWEST or",
        f"{TESTS} -k slow",
    ),
    (
        "a debugger is gone after a check",
        "checks/framework/guard.py",
        "sys.settrace(tracing)",
        "sys.settrace(None)",
        "checks/test_guard.py",
    ),
    (
        "an answer that is replaced is lost",
        "checks/framework/my_answers.py",
        "write_text(older, kept)",
        "pass",
        "checks/test_my_answers.py",
    ),
    (
        "the reference is judged as the student's answer",
        "checks/framework/check.py",
        "if student is self.reference:",
        "if False:",
        f"{TESTS} -k 'repeats or library'",
    ),
    (
        "a mistake that explains one answer is named for all",
        "checks/framework/comparison.py",
        "ALIKE = 0.75",
        "ALIKE = 0.1",
        "checks/test_comparison.py",
    ),
    (
        "a probability that is a little off passes",
        "checks/nb06/most_probable_path.py",
        "isclose(got[1], want[1], abs_tol=1e-9)",
        "isclose(got[1], want[1], abs_tol=1e-2)",
        f"{TESTS} -k 'message_of_its_own or little_off'",
    ),
    (
        "vertices that are no whole numbers pass, and the cells below stop",
        "checks/nb07/track_answers.py",
        "isinstance(vertex, bool) or not isinstance(vertex, int | np.integer)",
        "False",
        "checks/test_nb07.py",
    ),
    (
        "what look gave may be changed",
        "checks/nb07/track_stories.py",
        "if not np.array_equal(given, self._story.likelihoods[step]):",
        "if False:",
        "checks/test_nb07.py",
    ),
    (
        "an answer that changes its arguments spoils the cases of the next one",
        "checks/framework/answers.py",
        "copy.deepcopy(a) if isinstance(a, _COPIED) else a",
        "a",
        "checks/test_nb07.py",
    ),
    (
        "the biased graph may share dictionaries with the map",
        "checks/nb07/around_cycles.py",
        "if _shared(got, given[0]):",
        "if False:",
        f"{TESTS} -k 'wrong_answers_fail and around_cycles'",
    ),
]

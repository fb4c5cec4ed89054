"""Checks of students' answers."""

from tests.mutations import changes

MUTATIONS = [
    *changes("""
checks/framework/comparison.py | checks/test_checks.py -k 'messages or slow or limit or as_right_as'
large answers may be a little wrong
    atol=tolerance, rtol=0, equal_nan -> atol=tolerance, equal_nan

checks/framework/check.py | checks/test_checks.py -k slow
a slow solution is used, a fast one is not
    if ratio <= SLOWEST or -> if ratio >= SLOWEST or

checks/framework/guard.py | checks/test_guard.py
a debugger is gone after a check
    sys.settrace(tracing) -> sys.settrace(None)

checks/marking/wire.py | checks/test_marking.py -k 'no_bytes'
what comes back from an answer may call anything
    if (module, name) != (made.__module__, made.__name__): -> if False:

checks/marking/reports.py | checks/test_marking.py -k 'reports'
a spreadsheet calculates what students write
    v.startswith(_FORMULA) -> v is None

checks/framework/my_answers.py | checks/test_my_answers.py
an answer that is replaced is lost
    write_text(older, kept) -> pass

checks/framework/check.py | checks/test_checks.py -k 'repeats or library'
the reference is judged as the student's answer
    if student is self.reference: -> if False:

checks/framework/comparison.py | checks/test_comparison.py
a mistake that explains one answer is named for all
    ALIKE = 0.75 -> ALIKE = 0.1

checks/nb06/most_probable_path.py | checks/test_checks.py -k 'message_of_its_own or little_off'
a probability that is a little off passes
    isclose(got[1], want[1], abs_tol=1e-9) -> isclose(got[1], want[1], abs_tol=1e-2)

checks/nb07/track.py | checks/test_nb07.py
vertices that are no whole numbers pass, and the cells below stop
    isinstance(vertex, bool) or not isinstance(vertex, int | np.integer) -> False

checks/nb07/track_stories.py | checks/test_nb07.py
what look gave may be changed
    if not np.array_equal(given, self._story.likelihoods[step]): -> if False:

checks/framework/answers.py | checks/test_nb07.py
an answer that changes its arguments spoils the cases of the next one
    copy.deepcopy(a) if isinstance(a, _COPIED) else a -> a

checks/nb07/around_cycles.py | checks/test_checks.py -k 'wrong_answers_fail and around_cycles'
the biased graph may share dictionaries with the map
    if _shared(got, given[0]): -> if False:

checks/framework/answers.py | checks/test_nb09.py -k stay_as_it_is
a set that was changed is not noticed
    in zip(names, arguments, given, strict=False) -> in zip(names, given, given, strict=False)

checks/nb09/small_maps.py | checks/test_nb09.py -k lengths_of_paths
cells that are not reached have a negative length
    np.where(metres >= 0, metres, np.inf) -> metres

checks/nb09/small_places.py | checks/test_nb09.py -k wrong_with_a_call
the small robot may make a node where one is
    if (known := self._known(self._place)) is not None: -> if False:

checks/nb10/fits.py | checks/test_nb10.py -k out_of_sight
a point out of sight counts against a pose
    if off > _HIDDEN: -> if False:

checks/nb10/accept.py | checks/test_checks.py -k 'wrong_answers_fail and not_wrapped'
no headings lie on either side of 180 degrees
    wrap(one[2] + by) -> one[2] + by
"""),
    (
        "what was judged under another name is saved under that name only",
        "checks/framework/my_answers.py",
        "    needed.call(function, name)\n",
        "",
        "checks/test_my_answers.py",
    ),
    (
        "what an answer has started outlives it",
        "checks/marking/warden.py",
        "        for process in _children():\n",
        "        for process in []:\n",
        "checks/test_marking.py -k 'without_namespaces'",
    ),
    (
        "scans fit as soon as one of both says so",
        "checks/nb10/fits.py",
        "return np.minimum(there, ",
        "return np.maximum(there, ",
        "checks/test_nb10.py -k out_of_sight",
    ),
]

"""What is about everything: geometry, files, notebooks, the command line."""

MUTATIONS = [
    (
        "a turn counts half in the size of a motion",
        "geometry.py",
        "np.sqrt(2 * heading**2",
        "np.sqrt(heading**2",
        "test_geometry.py",
    ),
    (
        "a segment is as long as its line",
        "geometry.py",
        "/ length2, 0.0, 1.0)",
        "/ length2, 0.0, np.inf)",
        "test_geometry.py",
    ),
    (
        "what was half written is left behind",
        "files.py",
        "temporary.unlink(missing_ok=True)",
        "temporary.exists()",
        "test_files.py",
    ),
    (
        "a folder counts as a file that can be written",
        "files.py",
        "path.is_dir() or not os.access",
        "not os.access",
        "test_files.py",
    ),
    (
        "a stub stands where functions of the top level have it",
        "builder.py",
        "line[: len(line) - len(line.lstrip())] + STUB",
        '"    " + STUB',
        "test_builder.py",
    ),
    (
        "a check may stand before its exercise",
        "builder.py",
        "notebook.cells[number + 1 :]",
        "notebook.cells",
        "test_builder.py",
    ),
    (
        "one wrong answer too few is enough",
        "builder.py",
        "checks.count(name) < WRONG_ANSWERS",
        "checks.count(name) < WRONG_ANSWERS - 1",
        "test_builder.py",
    ),
    (
        "a demo that misses its goal ends well",
        "cli.py",
        "return 0 if outcome.reached else MISSED",
        "return 0",
        "test_cli.py -k missed",
    ),
    (
        "a map and worlds may be given together",
        "experiments/common/experiment.py",
        "if options.map is not None and options.worlds:",
        "if options.map is not None and not self.worlds:",
        "experiments/common/test_experiment.py",
    ),
]

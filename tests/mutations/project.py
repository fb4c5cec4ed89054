"""What is about everything: geometry, files, notebooks, the command line."""

from tests.mutations import changes

MUTATIONS = [
    *changes(r"""
observation.py | test_interfaces.py
a goal comes with the odometry of who took it
    np.zeros_like(self.odometry), -> self.odometry,
a goal comes with a laser scan
    np.full(np.shape(self.laser), np.nan), -> self.laser,

geometry.py | test_geometry.py
a segment is as long as its line
    / length2, 0.0, 1.0) -> / length2, 0.0, np.inf)

files.py | test_files.py
what was half written is left behind
    temporary.unlink(missing_ok=True) -> temporary.exists()
a link is replaced by the file
    Path(os.path.realpath(path)) if path.is_symlink() else path -> path
temporary files of runs under way are swept
    _KEPT = 24 * 3600.0 -> _KEPT = 3600.0
a folder counts as a file that can be written
    (found.exists() and not found.is_file()) -> False

commands/installed.py | commands/test_installed.py
a package whose code is gone counts as installed
    if any(not Path(str(package.locate_file(path))).exists() for path in _code(package)):
        -> if False:
an extra's packages are not looked for
    lost(f"{COURSE}[{','.join(extras)}]") -> lost(COURSE)

builder/notebooks.py | builder/test_notebooks.py
a stub stands where functions of the top level have it
    rf"\1{STUB}" -> rf"    {STUB}"
a check may stand before its exercise
    notebook.cells[number + 1 :] -> notebook.cells
one wrong answer too few is enough
    checks.count(name) < WRONG_ANSWERS -> checks.count(name) < WRONG_ANSWERS - 1

builder/mutants.py | builder/test_mutation.py
a stale reason for a harmless mutant is kept
    if stale: -> if False:

builder/mutation.py | builder/test_mutation.py
lines outside the solution are changed
    if statement.lineno not in within or isinstance(statement, ast.FunctionDef):
        -> if isinstance(statement, ast.FunctionDef):

commands/copy.py | commands/test_copy.py
a page that the student changed is overwritten
    if there not in (None, new, before.get(name)): -> if False:
a page that came in an older version stays
    if there not in (None, new, before.get(name)): -> if there not in (None, new):

course.py | test_course.py
an installed course is not looked for above the current folder
    for folder in (here, *here.parents) -> for folder in (here,)

commands/lab_files.py | commands/test_lab_files.py
widgets of a kernel that runs are lost when the page is opened again
    without_bars if runs else without_widgets -> without_widgets
a notebook that was only opened is to be saved
    dict(IPythonKernel.language_info) -> {"name": "python"}

commands/lab.py | test_cli.py -k settings
JupyterLab asks whether to fetch news
    filter(None, paths) -> filter(None, paths[:1])

cli.py | test_course.py
compiled code is kept beside an installed library
    if not is_checkout(): -> if is_checkout():

commands/demo.py | test_cli.py -k missed
a demo that misses its goal ends well
    return 0 if outcome.reached else MISSED -> return 0

commands/demo.py | test_cli.py -k told
long work is silent
    self._print(f"still {self._doing}") -> self._said = time.monotonic()

cli.py | test_cli.py -k quick
every command is imported at the start
    if [name] == arguments[:1]: -> if name != 'lab':

commands/experiment.py | test_cli.py -k family
an experiment does not print its table
    print(report.as_text()) -> report.as_text()

commands/train.py | test_cli.py -k wrong
wrong weights may be asked for
    if options.k not in known: -> if options.k not in known and not known:

commands/build.py | test_cli.py -k wrong
a notebook that is not there can be built
    if name not in known: -> if name not in known and not known:

experiments/common/experiment.py | experiments/common/test_experiment.py
a map and worlds may be given together
    if options.map is not None and options.worlds:
        -> if options.map is not None and not self.worlds:
"""),
    (
        "files that belong together take their places one by one",
        "files.py",
        (
            "                shutil.copymode(path, temporary)\n        for temporary, "
            "path in zip(temporaries, places, strict=True):\n            "
            "os.replace(temporary, path)\n"
        ),
        (
            "                shutil.copymode(path, temporary)\n            "
            "os.replace(temporary, path)\n"
        ),
        "test_files.py",
    ),
    (
        "links of solved notebooks lead to the teacher's page",
        "builder/notebooks.py",
        "    lead_to_notebooks(solved)\n",
        "",
        "builder/test_notebooks.py",
    ),
]

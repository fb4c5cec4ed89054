"""Checks the answers that students handed in, each in a process of its own."""

import argparse
import sys
from pathlib import Path

from tutorial_lib.checks.marking.handed_in import students_in
from tutorial_lib.checks.marking.judging import judges, marks_of
from tutorial_lib.checks.marking.reports import (
    Marked,
    lines_of,
    read_weights,
    write_csv,
    write_json,
    write_pages,
)
from tutorial_lib.commands.constants import WRONG_INPUT
from tutorial_lib.errors import InputError, one_line
from tutorial_lib.files import check_writable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the folders and what is written."""
    parser.add_argument(
        "folders", nargs="+", type=Path, metavar="FOLDER", help="a student's, or a whole class's"
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="a row for each exercise")
    parser.add_argument("--json", type=Path, metavar="FILE", help="the same, for programs")
    parser.add_argument("--feedback", type=Path, metavar="DIR", help="a page for each student")
    parser.add_argument(
        "--weights", type=Path, metavar="FILE", help="points: lines as 'to_local 2', 'others 1'"
    )


def run(options: argparse.Namespace) -> int:
    """Print every result, and write what was asked for."""
    for file in filter(None, (options.csv, options.json)):
        check_writable(file)
    if options.feedback is not None and options.feedback.exists() and not options.feedback.is_dir():
        raise InputError(f"{options.feedback}: is a file; give a folder for the pages")
    marked = []
    with judges(options.folders) as found:
        weights = dict.fromkeys(found.exercises, 1.0)
        if options.weights is not None:
            weights = read_weights(options.weights, found.exercises)
        if found.missing:
            print(f"note: {one_line(found.missing)}", file=sys.stderr)
        students = students_in(options.folders, found.exercises)
        for student, marks in marks_of(students, found):
            marked.append(Marked(student, marks, weights))
            print(lines_of(marked[-1]), flush=True)
    if options.csv is not None:
        write_csv(options.csv, marked)
    if options.json is not None:
        write_json(options.json, marked)
    if options.feedback is not None:
        print(f"{len(write_pages(options.feedback, marked))} pages in {options.feedback}")
    return _code(marked)


def _code(marked: list[Marked]) -> int:
    """0 where every folder had something to judge; those that had not are named at the end."""
    empty = [one.student for one in marked if one.student.problem]
    for student in empty:
        words = "give a student's folder my_answers, or a class's folder of such"
        print(
            f"error: {one_line(str(student.folder))}: {student.problem}; {words}", file=sys.stderr
        )
    return WRONG_INPUT if empty else 0

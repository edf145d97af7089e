"""``python -m sjasim.study``: many groups dance under several conditions, on many processes."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from .commands.main import main
from .studies.study_execution import execute, priced_plan
from .studies.study_options import parse_study
from .studies.study_page import print_plan, print_results
from .studies.study_results import results_as_json

ABOUT = "Simulate a study: groups of people who dance with several methods in turn, and compare the methods."


def command(arguments: Sequence[str], program: str = "python -m sjasim.study") -> None:
    """Run the study that the arguments describe, print its results, and write its folder if one is named."""
    options = parse_study(arguments, program, ABOUT)
    if options.dry_run:
        print_plan(*priced_plan(options.plan, options.execution), options.execution.processes)
        return

    results = execute(options.plan, options.execution)
    if options.json:
        sys.stdout.write(results_as_json(results))
    else:
        print_results(results)
    if options.execution.out is not None:
        from .studies.report.folders import write_report

        page = write_report(options.execution.out.expanduser(), overwrite=True)
        sys.stderr.write(f"study written to {options.execution.out}; its report is {page.name}\n")


if __name__ == "__main__":
    sys.exit(main(command))

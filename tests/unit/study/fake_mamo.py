"""The command ``mamo`` whose studies do the deeds of the tests."""

import sys

import mamo_core.study.run
from mamo_core.cli.main import main
from mamo_core.study.tasks import Work

WORK = Work(
    ready="study_deeds:ready",
    ready_to_classify="study_deeds:ready",
    solve="study_deeds:solve",
    classify="study_deeds:classify",
    generate="study_deeds:generate",
    generate_workspace="study_deeds:generate_workspace",
)

if __name__ == "__main__":
    mamo_core.study.run.Work = lambda: WORK  # type: ignore[misc, assignment]
    main(sys.argv[1:])

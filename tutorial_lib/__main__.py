"""``python -m tutorial_lib``."""

import sys

if sys.argv[1:2] == ["demo"] and not {"-h", "--help"} & {*sys.argv}:
    print("The demo takes about 20 s on two cores: importing the library first.", flush=True)

from tutorial_lib.cli import main

sys.exit(main(sys.argv[1:]))

"""The command ``kugelblitz``, also as ``python -m kugelblitz``."""

import sys

from ._kugelblitz import run_command


def main() -> int:
    """Runs the program with the arguments of this process. Returns its exit code."""
    return run_command(["kugelblitz", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

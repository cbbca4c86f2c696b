"""Loaded by workers under test: a line into the file COUNT_SCENES for each scene that is unpickled."""

import os

from kugelblitz import _kugelblitz


def dask_setup(worker):
    original = _kugelblitz.scene_of_state

    def counted(*state):
        with open(os.environ["COUNT_SCENES"], "a") as file:
            file.write(f"{os.getpid()}\n")
        return original(*state)

    _kugelblitz.scene_of_state = counted

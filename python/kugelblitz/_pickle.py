"""Scenes out of pickles."""

from ._kugelblitz import Scene


def scene_of_state(*state):
    return Scene._of_state(state)

"""Scenes out of pickles."""

from . import Scene


def scene_of_state(*state):
    return Scene._of_state(state)

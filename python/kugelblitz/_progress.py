"""Progress: what users give, as a callable that takes the steps done and their number."""

def steps(progress, unit):
    """A callable, or None where nobody wants to know. A bar that is made here is closed when it is let go."""
    if progress is None or progress is False:
        return None
    if progress is True:
        from tqdm.auto import tqdm

        progress = tqdm(total=0, unit=unit, unit_scale=True)
    if hasattr(progress, "update") and hasattr(progress, "n"):
        return _into(progress)
    if callable(progress):
        return progress
    raise TypeError("progress: give True, a bar with `update`, or a callable(done, total)")


def _into(bar):
    """Moves a bar with tqdm's protocol."""

    def move(done, total):
        if getattr(bar, "total", None) != total:
            bar.total = total
        bar.update(done - bar.n)

    return move

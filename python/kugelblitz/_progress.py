"""Progress: what users give, as a callable that takes the steps done and their number."""

from contextlib import contextmanager


@contextmanager
def steps(progress, unit):
    """Yields a callable, or None where nobody wants to know."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        from tqdm.auto import tqdm

        with tqdm(total=0, unit=unit, unit_scale=True) as bar:
            yield _into(bar)
    elif hasattr(progress, "update") and hasattr(progress, "n"):
        yield _into(progress)
    elif callable(progress):
        yield progress
    else:
        raise TypeError("progress: give True, a bar with `update`, or a callable(done, total)")


def _into(bar):
    """Moves a bar with tqdm's protocol."""

    def move(done, total):
        if getattr(bar, "total", None) != total:
            bar.total = total
        bar.update(done - bar.n)

    return move

"""What comparisons come to."""

# Their parts are what the library writes as JSON.
# mypy: disable-error-code="no-any-return"

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from operator import index
from typing import TYPE_CHECKING, Any, Literal, SupportsIndex, TypedDict, final

import numpy as np
from numpy.typing import NDArray

from . import _kugelblitz

if TYPE_CHECKING:
    from . import Explanation, Tinted


class Finding(TypedDict):
    """What is wrong with a ray."""

    kind: Literal["wrong id", "wrong id at a silhouette", "t", "normal"]
    ray: int
    pixel: list[int] | None
    says: str
    exact: str


class Verdict:
    """What a comparison has found. True where all is as it may be; ``str()`` is the text that the program prints."""

    def __init__(self, broken: list[str], summary: dict[str, Any], words: str, of: Any = None) -> None:
        self._broken, self._summary, self._words, self._of = broken, summary, words, of

    @property
    def kept(self) -> bool:
        """Whether all is as it may be."""
        return not self._broken

    @property
    def broken(self) -> list[str]:
        """What is not as it may be, a sentence each."""
        return self._broken.copy()

    def to_dict(self) -> dict[str, Any]:
        """All of it, under the keys of the program's ``--json``."""
        return deepcopy(self._summary)

    def _praise(self) -> str:
        return "all promises are kept"

    def __bool__(self) -> bool:
        return self.kept

    def __str__(self) -> str:
        return self._words

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {'; '.join(self._broken) or self._praise()}>"


@final
class Verification(Verdict):
    """Whether each kernel keeps what it promises, on a device and on the CPU."""


@final
class Difference(Verdict):
    """How two pictures differ. True where they differ by no more than is allowed."""

    _of: _kugelblitz.Compared

    @property
    def explained_by(self) -> str | None:
        """Transforms of the first picture that explain the differences, if there are such."""
        return _transforms(self._summary)

    @property
    def n_pixels(self) -> int:
        """Pixels that were compared; 0 where the sizes differ."""
        return self._summary["pixels"]

    @property
    def n_differing(self) -> int:
        """Pixels with any difference."""
        return self._summary["differing"]

    @property
    def first(self) -> list[int] | None:
        """Column and row of the first pixel with any difference."""
        return self.to_dict()["first"]

    @property
    def beyond(self) -> NDArray[np.int64]:
        """Indices of the pixels, row by row, that differ by more than is allowed of one."""
        return self._of.beyond()

    @property
    def channels(self) -> list[dict[str, Any]]:
        """The channels that both have, with ``name``, ``differing``, ``largest``, ``pixel`` and others."""
        return self.to_dict()["channels"]

    @property
    def picture(self) -> Tinted | None:
        """The differences as colours: equal pixels dark, allowed differences blue, others red to yellow; None where the
        sizes differ."""
        return self._of.picture()

    def _praise(self) -> str:
        return f"{self.n_differing} of {self.n_pixels} pixels differ, no more than is allowed"


@final
class HitDifference(Verdict):
    """How hits differ from the exact ones: how many are wrong, which, and what is right there."""

    _of: _kugelblitz.ComparedHits

    @property
    def explained_by(self) -> str | None:
        """Transforms that explain the errors, if there are such, as ``compare(…, transform=…)`` takes them."""
        return _transforms(self._summary)

    @property
    def by_object(self) -> list[dict[str, Any]]:
        """Objects with wrong rays, most wrong first: ``id``, ``name``, ``rays``, ``wrong_ids`` and others."""
        return self.to_dict()["by_object"]

    @property
    def allowed(self) -> str:
        """What may be wrong, in words."""
        return self._summary["allowed"]

    @property
    def n_rays(self) -> int:
        """Number of rays or pixels."""
        return self._summary["rays"]

    @property
    def away(self) -> dict[str, Any]:
        """Numbers of rays with wrong ids and the spread of errors: away from silhouettes, or of rays."""
        return self.to_dict()["away"]

    @property
    def silhouettes(self) -> dict[str, Any] | None:
        """The same at silhouettes; None for rays."""
        return self.to_dict()["silhouettes"]

    @property
    def counts(self) -> dict[str, int]:
        """Rays, wrong ids, false hits, false misses and wrong objects of all rays."""
        away, silhouettes = self.away, self.silhouettes or {}
        keys = ["rays", "wrong_ids", "false_hits", "false_misses", "wrong_object"]
        return {key: away[key] + silhouettes.get(key, 0) for key in keys} | {"wrong": len(self.wrong)}

    @property
    def wrong(self) -> NDArray[np.int64]:
        """Indices of the rays or pixels, row by row, with anything that is more wrong than it may be of one ray."""
        return self._of.wrong()

    @property
    def worst(self) -> list[Finding]:
        """The worst of each kind: what is said of a ray, and what is right."""
        return self.to_dict()["worst"]

    @property
    def picture(self) -> Tinted | None:
        """The errors as colours: false hits red, false misses orange, other objects yellow, errors of t and normals
        blue; None for rays."""
        return self._of.picture()

    def at(self, at: SupportsIndex | Sequence[int]) -> list[Finding]:
        """What is wrong with one ray, by its index or a pixel's (column, row): as ``worst``, and an empty list where
        all is as it may be."""
        return self._of.at(self._index(at))

    def explain(
        self,
        at: SupportsIndex | Sequence[int],
        *,
        all: bool = False,
        lang: Literal["en", "de"] = "en",
        digits: int = 6,
    ) -> Explanation:
        """The ray in numbers, by its index or a pixel's (column, row)."""
        return self._of.explain(self._index(at), all, lang, digits)

    def _index(self, at: Any) -> int:
        """The index of a ray, or of a pixel's (column, row) in the whole picture."""
        whole = self._summary
        try:
            if np.ndim(at) == 0:
                column, row, n = index(at), 0, whole["rays"]
            else:
                left, top, n, _ = whole["crop"] or [0, 0, *whole["size"]]
                x, y = at
                column, row = index(x) - left, index(y) - top
        except (TypeError, ValueError):
            raise TypeError("at: give the index of a ray, or (column, row) of a picture") from None
        if 0 <= column < n and 0 <= row * n + column < whole["rays"]:
            return row * n + column
        raise ValueError(f"at: {at} is none of the {whole['rays']} that were compared")

    def _praise(self) -> str:
        return f"all {self.n_rays} are as they may be"


@final
class Comparison(Verdict):
    """A picture or hits, compared with a scene."""

    _of: tuple[HitDifference | None, Difference | None]

    @property
    def hits(self) -> HitDifference | None:
        """Ids, t and normals; None without them."""
        return self._of[0]

    @property
    def colors(self) -> Difference | None:
        """The colours; None without them."""
        return self._of[1]

    @property
    def explained_by(self) -> str | None:
        """Transforms that explain the errors, if there are such."""
        parts = [part.explained_by for part in self._of if part is not None]
        return next((part for part in parts if part is not None), None)

    @property
    def picture(self) -> Tinted | None:
        """The errors as colours, of hits if there are any."""
        part = self.colors if self.hits is None else self.hits
        return None if part is None else part.picture

    def _praise(self) -> str:
        return "all is within the allowed errors"


def _transforms(summary: dict[str, Any]) -> str | None:
    found = summary["explained_by"]
    return None if found is None else found["transforms"]

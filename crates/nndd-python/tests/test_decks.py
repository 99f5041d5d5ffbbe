"""The decks of the example cases are those that `decks.py` writes."""

from __future__ import annotations

import nndd
import numpy as np
import pytest
from decks import DECKS, FOLDER


@pytest.mark.parametrize("name", DECKS)
def test_a_deck_is_what_the_script_writes(name: str) -> None:
    assert (FOLDER / name).read_text(encoding="utf-8") == DECKS[name]()


@pytest.mark.parametrize(("name", "volume"), [("bracket.inp", 2.5), ("tilted.inp", 4.0)])
def test_a_deck_has_its_volume(name: str, volume: float) -> None:
    mesh = nndd.Mesh.read(FOLDER / name)
    corners = mesh.points[mesh._cells]
    assert np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6 == pytest.approx(volume)

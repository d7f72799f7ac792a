"""The gallery: validation tests draw what they have just computed, when asked to.

Set `HEAVE_GALLERY` to a folder and each test that calls the `gallery` fixture leaves a PNG and its caption there;
`benchmarks/gallery.py` runs the suite that way and writes the page. Without it nothing is drawn and matplotlib is not
even imported.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Draw = Callable[["Figure"], None]


@pytest.fixture
def gallery(request: pytest.FixtureRequest) -> Callable[[str, str, Draw], None]:
    """Return `gallery(name, caption, draw)`: calls `draw(figure)`, saves `name`.png if a gallery is being made.

    The caption says what is shown and where the reference comes from. Call it before the assertions: a failing case
    is worth seeing.
    """

    def save(name: str, caption: str, draw: Draw) -> None:
        folder = os.environ.get("HEAVE_GALLERY")
        if not folder:
            return
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 (matplotlib only when drawing)
        from matplotlib.figure import Figure  # noqa: PLC0415 (matplotlib only when drawing)

        figure = Figure(figsize=(8.0, 4.5), layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        path = Path(folder)
        path.mkdir(parents=True, exist_ok=True)
        figure.savefig(path / f"{name}.png", dpi=110)
        entry = {"caption": caption, "test": request.node.nodeid}
        (path / f"{name}.json").write_text(json.dumps(entry), encoding="utf-8")

    return save

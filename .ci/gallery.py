"""Run docs/gallery.ipynb and store its outputs in it: `make gallery`. Needs the extra `docs`.

Pictures are stored with 64 colours, and films with every fourth frame at 60 % of their size, so that the notebook stays
below 1 MB; a notebook of one's own shows both in full.
"""

from __future__ import annotations

import io
import re
import sys
from base64 import b64decode, b64encode
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image, ImageSequence

GALLERY = Path(__file__).parents[1] / "docs" / "gallery.ipynb"
LARGEST = 1_000_000  # bytes
COLOURS = 64
FILM_SCALE, FRAMES = 0.6, 4


def main() -> int:
    """Run all cells and write the notebook; raises the error of a cell that fails."""
    notebook = nbformat.read(GALLERY, as_version=4)
    NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # times of the run
        for output in cell.get("outputs", []):
            _shrink(output.get("data", {}))
    notebook.metadata.language_info.pop("version", None)
    text = nbformat.writes(notebook)
    if len(text.encode()) > LARGEST:
        sys.exit(f"the notebook has {len(text.encode())} bytes; the limit is {LARGEST}: make its pictures smaller")
    GALLERY.write_text(text + "\n", encoding="utf-8")
    print(f"{GALLERY.name}: {len(text.encode()) / 1e6:.2f} MB")
    return 0


def _shrink(data: dict[str, str]) -> None:
    """Make the pictures of an output smaller, alone or inside HTML."""
    if "image/png" in data:
        data["image/png"] = _png(data["image/png"])
    if "text/html" in data:
        for kind, shrink in (("png", _png), ("gif", _gif)):
            pattern = rf"(data:image/{kind};base64,)([A-Za-z0-9+/=\s]+)"
            data["text/html"] = re.sub(pattern, lambda m, f=shrink: m[1] + f(m[2]), data["text/html"])


def _png(text: str) -> str:
    image = Image.open(io.BytesIO(b64decode(text))).convert("RGB")
    return _encode(image.quantize(COLOURS, dither=Image.Dither.NONE), "PNG", optimize=True)


def _gif(text: str) -> str:
    film = Image.open(io.BytesIO(b64decode(text)))
    size = tuple(round(FILM_SCALE * length) for length in film.size)
    frames = [frame.convert("RGB").resize(size) for frame in ImageSequence.Iterator(film)][::FRAMES]
    few = [frame.quantize(COLOURS // 2, dither=Image.Dither.NONE) for frame in frames]
    lasts = FRAMES * film.info["duration"]
    return _encode(few[0], "GIF", save_all=True, append_images=few[1:], duration=lasts, loop=0, optimize=True)


def _encode(image: Image.Image, kind: str, **how: object) -> str:
    buffer = io.BytesIO()
    image.save(buffer, kind, **how)
    return b64encode(buffer.getvalue()).decode()


if __name__ == "__main__":
    sys.exit(main())

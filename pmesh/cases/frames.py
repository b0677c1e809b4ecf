"""Frames of a movie and the file they become: GIF by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

import importlib
import io
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.plain import SHADE
from remesh.errors import InputError, StorageError

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont

Pixels = NDArray[np.uint8]
Kind = Literal["gif", "mp4"]
KINDS: tuple[Kind, ...] = ("gif", "mp4")
STRIP = 28  # pixels above the picture, for the time
BAR = 90  # pixels that a bar of colours is long
SHADES, DARKEST = 24, 0.36  # entries of a palette that are kept for shadows, and their depth
SAMPLES = 8  # frames that a palette is made from


@dataclass(frozen=True, kw_only=True)
class Frames:
    """Pictures as palette entries (height, width), and the palette; or their colours."""

    pixels: Iterator[Pixels]  # each (height, width), without a palette (height, width, 3)
    palette: Pixels | None = None  # (256, 3)


def written(frames: Frames, kind: Kind, fps: float) -> bytes:
    """The content of a movie file."""
    return _gif(frames, fps) if kind == "gif" else _mp4(frames, fps, ffmpeg())


def strip(width: int, left: str, right: str) -> Pixels:
    """A line of text, dark on white, (STRIP, width)."""
    from PIL import Image, ImageDraw

    line = Image.new("L", (width, STRIP), 255)
    pen, letters = ImageDraw.Draw(line), _font()
    pen.text((8, STRIP // 2), left, fill=0, font=letters, anchor="lm")
    if letters.getlength(left + right) < width - 32:
        pen.text((width - 8, STRIP // 2), right, fill=0, font=letters, anchor="rm")
    return np.asarray(line)


def colour_strip(
    width: int,
    left: str,
    label: str | None = None,
    limits: tuple[float, float] | None = None,
    colours: str = "viridis",
) -> Pixels:
    """A line of text and, with ``limits``, a bar of the colours, (STRIP, width, 3)."""
    line = np.repeat(strip(width, left, "")[..., None], 3, axis=2)
    if limits is None:
        return line
    from matplotlib import colormaps
    from PIL import Image, ImageDraw

    picture, letters = Image.fromarray(line), _font()
    pen = ImageDraw.Draw(picture)
    low, high = f"{label or ''}  {limits[0]:.3g} ", f" {limits[1]:.3g}"
    last = width - 8 - round(letters.getlength(high))
    first = last - BAR
    if first - letters.getlength(low) < letters.getlength(left) + 24:
        return line
    middle = STRIP // 2
    pen.text((first, middle), low, fill="black", font=letters, anchor="rm")
    pen.text((last, middle), high, fill="black", font=letters, anchor="lm")
    drawn = np.array(picture)
    shades = np.rint(255 * colormaps[colours](np.linspace(0, 1, BAR))[:, :3])
    drawn[middle - 5 : middle + 5, first:last] = shades.astype(np.uint8)
    return drawn


def _font() -> FreeTypeFont:
    """The letters of the figures."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), 14)


def _gif(frames: Frames, fps: float) -> bytes:
    """A GIF that repeats."""
    from PIL import Image

    pictures = [Image.fromarray(pixels) for pixels in frames.pixels]
    if frames.palette is None:
        pictures = _indexed(pictures)
    else:
        for picture in pictures:
            picture.putpalette(frames.palette.tobytes())
    stream = io.BytesIO()
    pictures[0].save(
        stream, format="GIF", save_all=True, append_images=pictures[1:], loop=0,
        duration=max(20, 10 * round(100 / fps)), optimize=False,
    )  # fmt: skip
    return stream.getvalue()


def _indexed(pictures: Sequence[Image]) -> list[Image]:
    """Pictures in one palette: rare colours count as much as frequent ones, white stays white."""
    from PIL import Image
    from scipy.spatial import KDTree

    spread = pictures[:: -(-len(pictures) // SAMPLES)]
    found = np.unique(np.concatenate([np.unique(_packed(picture)) for picture in spread]))
    colours = Image.fromarray(_unpacked(found)[None]).quantize(
        255 - SHADES, method=Image.Quantize.MEDIANCUT, kmeans=1, dither=Image.Dither.NONE
    )
    table = np.full((256, 3), 255, np.uint8)
    known = np.array(colours.getpalette(), np.uint8).reshape(-1, 3)[: 255 - SHADES]
    table[: len(known)] = known
    dark = np.linspace(0.0, DARKEST, SHADES)[:, None] * (255 - np.array(SHADE))
    table[-SHADES:] = np.rint(255 - dark)
    tree, results = KDTree(table.astype(float)), []
    for picture in pictures:
        own, where = np.unique(_packed(picture), return_inverse=True)
        entries = tree.query(_unpacked(own).astype(float))[1].astype(np.uint8)
        result = Image.fromarray(entries[where].reshape(picture.size[::-1]))
        result.putpalette(table.tobytes())
        results.append(result)
    return results


def _packed(picture: Image) -> NDArray[np.int64]:
    """Each colour as one number."""
    red, green, blue = np.asarray(picture, np.int64).reshape(-1, 3).T
    return (red << 16) + (green << 8) + blue


def _unpacked(numbers: NDArray[np.int64]) -> Pixels:
    return np.stack([numbers >> 16, numbers >> 8 & 255, numbers & 255], axis=1).astype(np.uint8)


def ffmpeg() -> str:
    """The program that writes MP4; refuses if there is none."""
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        found = shutil.which("ffmpeg")
    if found is None:
        raise InputError(
            "an MP4 needs ffmpeg, which is not here",
            hint='--format gif, or: pip install "pmesh-flow[movie]"',
        )
    return found


def _mp4(frames: Frames, fps: float, program: str) -> bytes:
    """An H.264 movie that browsers play."""
    table = frames.palette
    pictures = [pixels if table is None else table[pixels] for pixels in frames.pixels]
    height, width = pictures[0].shape[:2]
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "movie.mp4"
        words = [
            program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-", "-an", "-c:v", "libx264",
            "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(target),
        ]  # fmt: skip
        done = subprocess.run(
            words, input=b"".join(p.tobytes() for p in pictures), capture_output=True, check=False
        )
        if done.returncode or not target.is_file():
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise StorageError(
                f"ffmpeg could not write the movie: {said[-1] if said else done.returncode}",
                hint="--format gif",
            )
        return target.read_bytes()

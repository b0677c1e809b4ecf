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

from remesh.errors import InputError, StorageError

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont

Pixels = NDArray[np.uint8]
Kind = Literal["gif", "mp4"]
KINDS: tuple[Kind, ...] = ("gif", "mp4")
STRIP = 28  # pixels above the picture, for the time
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
        255, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE
    )
    table = np.full((256, 3), 255, np.uint8)
    known = np.array(colours.getpalette(), np.uint8).reshape(-1, 3)[:255]
    table[: len(known)] = known
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

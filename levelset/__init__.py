"""Where an interface is: shapes by their signed distance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from remesh.lazy import lazy_names

if TYPE_CHECKING:
    from levelset import shapes as shapes

__all__ = ["shapes"]

__getattr__, __dir__ = lazy_names(globals(), {"shapes": "levelset.shapes"})

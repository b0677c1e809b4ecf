"""Where an interface is: shapes by their signed distance."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from levelset import shapes as shapes

__all__ = ["shapes"]


def __getattr__(name: str) -> Any:
    """Import the public module when it is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f"levelset.{name}")


def __dir__() -> list[str]:
    """The public names."""
    return sorted(__all__)

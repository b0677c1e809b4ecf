"""Public names of a package that are imported from their modules when first asked for."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any


def lazy_names(
    namespace: dict[str, Any], home: Mapping[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package whose ``home`` says where each name lives.

    A home that holds no such name is what is meant itself: ``shapes`` in ``levelset.shapes``.
    """

    def find(name: str) -> Any:
        if name not in home:
            raise AttributeError(f"module {namespace['__name__']!r} has no attribute {name!r}")
        module = importlib.import_module(home[name])
        value = getattr(module, name, module)
        namespace[name] = value
        return value

    return find, lambda: sorted(namespace["__all__"])

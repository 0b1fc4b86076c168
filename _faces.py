"""Faces of folders: their public names, each loaded when it is first used."""

import re
from collections.abc import Callable

import lazy_loader


def attach_face(
    package: str, file: str
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a folder, from the stub beside its ``file``.

    Lines like ``from .chain import Joint as Joint`` need no parser: ``lazy_loader.attach_stub``
    loads ``ast`` for them, which a cold start would feel.
    """
    with open(file + "i", encoding="utf-8") as stub:  # noqa: PTH123  (pathlib costs as much)
        rows = re.findall(
            r"^from \.([\w.]+) import (\w+) as ", stub.read(), re.MULTILINE
        )
    names: dict[str, list[str]] = {}
    for module, name in rows:
        names.setdefault(module, []).append(name)
    return lazy_loader.attach(package, submod_attrs=names)

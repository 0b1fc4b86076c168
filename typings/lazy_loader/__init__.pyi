from collections.abc import Callable, Mapping, Sequence

def attach(
    package_name: str,
    submodules: None = None,
    submod_attrs: Mapping[str, Sequence[str]] = ...,
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]: ...

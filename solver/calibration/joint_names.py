"""Names that another program gives a robot's joints."""

from collections.abc import Sequence

from .options import UsageError


def joints_named(words: str, joints: Sequence[str]) -> tuple[str, ...]:
    """Return what ``--joints`` says that another program calls a model's joints.

    Args:
        words: Names between commas, or one word in which ``*`` is each of the model's names.
        joints: The model's names, in chain order.

    Raises:
        UsageError: There are more names than joints, or fewer.
    """
    named = words.split(",") if "*" not in words else [words.replace("*", j) for j in joints]
    if len(named) != len(joints):
        raise UsageError(
            f"--joints {words}: {len(named)} names, but the model has {len(joints)} joints: "
            f"{', '.join(joints)}"
        )
    return tuple(name.strip() for name in named)

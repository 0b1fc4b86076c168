# pyarrow has no types of its own; what is used of it is named here.
class ArrowException(Exception): ...  # noqa: N818

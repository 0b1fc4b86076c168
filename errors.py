"""The base of all errors that a user can mend."""


class MukcaError(Exception):
    """Base of all errors that a user can mend; the message is one line.

    The line says what is wrong, where (file, line, joint), and what would work.

    Attributes:
        failed: The input was good, and the work ran, but its result is not to be used.
    """

    failed: bool = False

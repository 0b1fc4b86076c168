"""The verbs of the command line, one module each: its arguments, and what it runs.

Each module has ``add_arguments(parser)`` and ``run(arguments, terminal) -> exit status``.
"""

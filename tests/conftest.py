"""Options of the test run."""

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--hardware",
        action="append",
        default=[],
        metavar="NAME=ADDRESS",
        help="run the drivers' contract on a robot, as in franka=172.16.0.2; may be repeated",
    )

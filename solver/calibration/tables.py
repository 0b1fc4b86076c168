"""The tables of a calibration: methods, checks, proof, and studies of its posterior.

A check is a function of measurements, in the order of the table. A study writes one section of
``calibration.json``, and may read those of studies before it.
"""

from functools import partial

from .. import studies
from ..curves import with_joint_curves
from . import findings
from .checks import inspected, lone_sockets
from .fit import Methods
from .folds import with_folds
from .located_sockets import tables_of_sockets
from .outlook import OUTLOOK
from .robot_calibration import Tables
from .set_ups import right_handed, set_up_anew

METHODS = Methods(with_joint_curves, studies.project_to_geometry)
PROOF = partial(with_folds, methods=METHODS)
CHECKS = (right_handed, set_up_anew, inspected, lone_sockets, tables_of_sockets)
STUDIES = (
    *studies.STUDIES,
    findings.CHECKS,
    findings.HYPOTHESES,
    OUTLOOK,
)
TABLES = Tables(checks=CHECKS, studies=STUDIES, methods=METHODS, prove=PROOF)

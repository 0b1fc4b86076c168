"""The table of checks of a placement.

To add a check:

1. Write a file with one function of (Evidence, Measurement) that returns diagnostics, each with a
   code of its own: what it looks for, by what evidence, in which words.
2. Put the function into FIT_CHECKS if it believes the robust fit, so that it is silent where wrong
   columns spoil that, or into RECORDING_CHECKS if it needs the recording alone.
3. Test by ``mukca check`` that it finds the mistake, and is silent on sound recordings.
"""

from collections.abc import Callable

from ..data import Measurement
from .configurations import duplicates, motionless_joints
from .diagnostic import Diagnostic
from .evidence import Evidence
from .far_samples import far_samples
from .outside_socket import outside_socket
from .sample_count import few_samples

Check = Callable[[Evidence, Measurement], list[Diagnostic]]
FIT_CHECKS: tuple[Check, ...] = (outside_socket, far_samples)
RECORDING_CHECKS: tuple[Check, ...] = (few_samples, duplicates, motionless_joints)

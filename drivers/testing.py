"""Alias of :mod:`.contract_tests`, by which published plug-ins know it."""

from .contract_tests import DriverContract as DriverContract

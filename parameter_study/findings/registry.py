"""Sets of findings that a study file can name."""

from collections.abc import Mapping
from types import MappingProxyType

from updamp.parameter_study.findings.finding import Finding
from updamp.parameter_study.findings.pesaresi2017 import PESARESI_2017

FINDINGS: Mapping[str, tuple[Finding, ...]] = MappingProxyType({"pesaresi2017": PESARESI_2017})

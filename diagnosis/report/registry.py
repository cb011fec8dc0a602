"""Every section of the report, in its order on the page. One that has nothing to show leaves itself out."""

from updamp.diagnosis.report.section import Section
from updamp.diagnosis.report.sections import (
    backbones,
    calibration,
    contact_states,
    features,
    frequency_response,
    origin,
    outcome,
    pictures,
    residual_amplitude,
    residual_map,
    scatter,
    secondary,
)

SECTIONS: tuple[Section, ...] = (
    outcome.SECTION,
    residual_map.SECTION,
    frequency_response.SECTION,
    residual_amplitude.SECTION,
    backbones.SECTION,
    calibration.SECTION,
    features.SECTION,
    scatter.SECTION,
    contact_states.SECTION,
    pictures.SECTION,
    secondary.SECTION,
    origin.ASSUMPTIONS,
    origin.PROVENANCE,
)

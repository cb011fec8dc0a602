"""The one builder: reduced model, contact at rest, calibration and effects become one model; rigs given by modes."""

"""Contact at rest: models of the pressure, unilateral contact with friction."""

"""The error of a rig that can be built but not meshed well enough."""


class GeometryError(ValueError):
    """Names the key of the rig file, its value and what would be allowed."""

    def __init__(self, key: str, value: str, allowed: str) -> None:
        super().__init__(f"{key} = {value}: {allowed}")
        self.key = key
        self.value = value
        self.allowed = allowed

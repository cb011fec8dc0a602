"""What the finite elements need to know of a material."""

from typing import Protocol


class ElasticMaterial(Protocol):
    """Isotropic linear elastic: Young's modulus [Pa], Poisson's ratio [-], density [kg/m^3]."""

    @property
    def youngs_modulus(self) -> float: ...
    @property
    def poissons_ratio(self) -> float: ...
    @property
    def density(self) -> float: ...


def lame_parameters(material: ElasticMaterial) -> tuple[float, float]:
    """First and second Lame parameter [Pa]; the second is the shear modulus."""
    modulus, ratio = material.youngs_modulus, material.poissons_ratio
    return modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)), modulus / (2 * (1 + ratio))

"""Contact laws that a rig file can name."""

from collections.abc import Callable

from updamp.hbm.contact.coulomb_circle import CoulombCircle
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import FrictionLaw

CONTACT_LAWS: dict[str, Callable[[int], FrictionLaw]] = {
    "jenkins_box": JenkinsBox,
    "jenkins_box_sampled": SampledJenkinsBox,
    "coulomb_circle": CoulombCircle,
}

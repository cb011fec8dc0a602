"""The problem with 146 contacts that the open peers were measured on: 50 modes, harmonics 0-3, 128 samples, 40 N."""

from dataclasses import replace

from updamp.benchmarks.harmonic_balance.measure import Cost, branch_cost, in_a_process
from updamp.benchmarks.sensitivity_cost import FORCE, WINDOW, load
from updamp.hbm.contact.jenkins_box import JenkinsBox
from updamp.hbm.contact.jenkins_box_sampled import SampledJenkinsBox
from updamp.hbm.contact.law import ContactLaw
from updamp.hbm.problem.system import Excitation

MODEL = "c_model_146.npz"
LAWS: dict[str, ContactLaw] = {"c_model_146": JenkinsBox(2), "c_model_146_sampled": SampledJenkinsBox(2)}
THREADS = {"one_thread": 1, "two_threads": 2}

# Seconds of processor time of one residual with Jacobian and of one point, on a machine with two cores, one thread.
PEERS: dict[str, tuple[float, float | None]] = {
    "tmdsimpy": (0.36, 2.0),
    "pyHarm-os": (4.1, 30.0),
    "plain numba check code": (0.011, None),
}

Costs = dict[str, dict[str, Cost | None]]


def cost(law: ContactLaw, model: str = MODEL) -> Cost | None:
    """None where the model is not beside the checkout."""
    system = load(model)
    if system is None:
        return None
    system = replace(system, groups=tuple(replace(group, law=law) for group in system.groups))
    return branch_cost(system, Excitation(system.free.row("excitation"), FORCE), WINDOW)


def costs(most_threads: int = 2, model: str = MODEL) -> Costs:
    """By law, then by threads; None for more than `most_threads`."""
    return {
        name: {
            threads: in_a_process(count, cost, law, model) if count <= most_threads else None
            for threads, count in THREADS.items()
        }
        for name, law in LAWS.items()
    }

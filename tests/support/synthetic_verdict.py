"""A verdict over the synthetic comparison, for tests of what shows it: made-up effects on its real residuals."""

from collections.abc import Iterator

import numpy as np

from updamp.comparison.comparison import Comparison
from updamp.diagnosis.verdict import (
    Candidate,
    Confounding,
    ErrorReached,
    Explanation,
    FittedParameter,
    MissingForce,
    NextMeasurement,
    Signature,
    Step,
    Verdict,
)

NAN = float("nan")
EFFECTS = {
    "material_damping": "The material damps more the larger the strain.",
    "contact_viscosity": "A film between the contact faces adds viscous damping.",
    "shaker_attachment": "The shaker's moving mass, spring and dashpot hang on the blade.",
    "blade_mistuning": "The two blades are not alike.",
    "clamp_flexibility": "The root gives way: it is not clamped rigidly.",
    "wire_stiffness": "The pulling wire holds the damper more or less than modelled.",
}


def synthetic_verdict(comparison: Comparison) -> Verdict:
    """`material_damping` identified, with shaker mass and mistuning looking alike"""
    return Verdict(
        verdict="identified",
        sentence="Material damping that grows with strain is missing: it explains 94 % of the misfit in the fit "
        "and 91 % on the force levels and the mode that no fit saw.",
        effects=("material_damping",),
        group=(),
        candidates=_candidates(),
        error=ErrorReached(5.61, 1.12, 4.83, 1.24, 1.0),
        next_measurement=(
            NextMeasurement(
                "OOP at 5 N with 20 g on the left tip", ("shaker_attachment", "blade_mistuning"), 11.2, 1.5
            ),
            NextMeasurement("Third harmonic at 17 N, IP", ("contact_viscosity", "material_damping"), 4.1, 0.75),
        ),
        signatures=tuple(_signatures(comparison)),
        confounding=_confounding(),
        missing_forces=_missing_forces(),
        history=(
            Step((), 5.61, 4.83),
            Step(("contact_viscosity",), 3.10, 3.62),
            Step(("contact_viscosity", "material_damping"), 1.05, 1.31),
            Step(("material_damping",), 1.12, 1.24),
        ),
        provenance={"Catalogue": "16 effects, SHA-256 21c43f5a90be"},
        explanations=(
            Explanation(("material_damping",), 0.97, 1.12, 1.24),
            Explanation(("contact_viscosity", "material_damping"), 0.026, 1.05, 1.31),
            Explanation(("contact_viscosity",), 0.004, 3.1, 3.62),
            Explanation((), 0.0, 5.61, 4.83),
        ),
    )


def _candidates() -> tuple[Candidate, ...]:
    names = list(EFFECTS)
    fitted = {
        "material_damping": (
            FittedParameter("loss_factor_growth", "1/mm", 0.021, 0.019, 0.023, 0.0, 0.0, 0.1),
            FittedParameter("exponent", "", 1.02, 0.91, 1.13, 0.0, 0.0, 3.0),
        ),
        "contact_viscosity": (FittedParameter("viscosity", "N*s/m**3", 2.1e7, 1.6e7, 2.6e7, 0.0, 0.0, 2.1e7),),
    }
    numbers = (
        (41.2, 0.71, 1697.0, 1610.0, 1595.0, 0.74, True, ""),
        (22.0, 0.44, 484.0, 890.0, 875.0, 0.25, False, "parameter at its physical bound"),
        (6.4, 0.35, 41.0, 12.0, -3.0, 0.01, False, "no gain on held-out data"),
        (6.1, 0.33, 37.2, 10.0, -5.0, -0.02, False, "no gain on held-out data"),
        (1.2, 0.08, 1.4, NAN, NAN, NAN, False, "not identifiable with these data"),
        (0.6, 0.29, 0.4, NAN, NAN, NAN, False, "score below 3"),
    )
    return tuple(
        Candidate(name, EFFECTS[name], *row[:6], fitted.get(name, ()), row[6], row[7])
        for name, row in zip(names, numbers, strict=True)
    )


def _signatures(comparison: Comparison) -> Iterator[Signature]:
    """The right effect follows the residual, the wrong ones follow other shapes."""
    for pair in comparison.curves:
        mine = [r for r in comparison.residuals if (r.run, r.channel, r.repeat) == (pair.run, pair.channel, 1)]
        frequency = np.array([r.frequency for r in mine])
        amplitude, phase = (np.array([getattr(r, part) for r in mine]) for part in ("amplitude", "phase"))
        across = np.linspace(-1, 1, len(mine))
        smooth = np.ones(3) / 3
        for k, effect in enumerate(EFFECTS):
            share = np.exp(-0.8 * k)
            other = np.abs(amplitude).max() * 0.3 * np.sin((k + 1) * 2 * across)
            yield Signature(
                effect, pair.run, pair.mode, pair.level, pair.channel, frequency,
                share * np.convolve(amplitude, smooth, "same") + (1 - share) * other,
                share * np.convolve(phase, smooth, "same") + (1 - share) * other[::-1], amplitude, phase,
            )  # fmt: skip


def _confounding() -> Confounding:
    generator = np.random.default_rng(3)
    vectors = generator.standard_normal((len(EFFECTS), 8))
    vectors[3] = -vectors[2] + 0.15 * generator.standard_normal(8)
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    return Confounding(tuple(EFFECTS), vectors @ vectors.T, 0.9, (("shaker_attachment", "blade_mistuning"),))


def _missing_forces() -> tuple[MissingForce, ...]:
    generator = np.random.default_rng(5)
    forces = []
    for mode, stiffness, damping in (("IP", 9e3, 0.3), ("OOP", 2e3, 2.4)):
        level = np.repeat([0.096, 0.32, 0.96, 5.0, 17.0], 6)
        amplitude = 3e-6 * (level / 0.096) ** 0.9 * (1 + 0.2 * generator.standard_normal(30))
        ones, noise = np.ones(30), generator.standard_normal((2, 30))
        forces.append(
            MissingForce(
                mode, level, amplitude, stiffness + 600 * noise[0], 600 * ones,
                damping * (1 + amplitude / 1e-4) + 0.2 * noise[1], 0.2 * ones,
                "damping that grows with amplitude, as in the material; stiffness constant",
            )
        )  # fmt: skip
    return tuple(forces)

"""Which fit of a diagnosis the values of effects are taken from: one with all of them, where there is one."""

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass

from updamp.diagnosis.verdict import FittedParameter, Verdict


@dataclass(frozen=True)
class FittedEffects:
    """parameters: of each effect that was fitted; together: effects of the fit that they are of, None where they are of
    several fits"""

    parameters: Mapping[str, tuple[FittedParameter, ...]]
    together: frozenset[str] | None

    def notes(self, names: Sequence[str], kept: Set[str]) -> Iterator[str]:
        """What a person should know of values that were not fitted together. kept: effects of the rig file that stay"""
        if self.together is None:
            yield f"{' and '.join(names)} were not fitted together: each has the value of a fit of its own"
        elif self.together > frozenset(names):
            yield (
                f"{' and '.join(sorted(self.together & kept))} stays as the rig file has it; the diagnosis fitted it "
                f"anew together with {' and '.join(names)}"
            )


def fitted_effects(verdict: Verdict, names: Sequence[str], kept: Set[str]) -> FittedEffects:
    """Of the fit with these effects and those that the rig file keeps, else of the one with these alone, else of a
    fit of each. kept: effects of the rig file that stay"""
    explanations = {frozenset(e.effects): e for e in verdict.explanations if e.fitted}
    for together in (frozenset(names) | kept, frozenset(names)):
        if together and together in explanations:
            of_each = {effect.name: effect.parameters for effect in explanations[together].fitted}
            return FittedEffects({name: of_each[name] for name in names}, together)
    # a diagnosis of before 27 November 2026 has one fit of each, that of the verdict for those that it names
    of_candidates = {c.name: c.parameters for c in verdict.candidates if c.parameters and c.name in names}
    is_one_fit = len(names) == 1 or set(names) <= set(verdict.effects)
    return FittedEffects(of_candidates, frozenset(names) if is_one_fit else None)

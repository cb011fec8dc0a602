"""Pictures of a run: what each is made of, and what draws it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from updamp.effects.rig_model import RigModel
from updamp.fem.contact_places import NINE_PLACES, nearest_patch
from updamp.fem.lumped_damper import DAMPER_MODELS
from updamp.geometry.rig_mesh import mirrored_mesh
from updamp.hbm.analysis.adaptive import with_orders
from updamp.hbm.analysis.settings import setting_of
from updamp.hbm.continuation.response_curve import ResponseCurve
from updamp.hbm.harmonics import Harmonics
from updamp.hbm.newton.observe import ContactState, contact_states
from updamp.model.build import rig_model
from updamp.model.force_loops import ForceLoop, loop_of_contact
from updamp.pictures import bodies, faces, force_loops, kinematics, response
from updamp.pictures.modes import ModeShape, animation, panel
from updamp.pictures.resonance import resonance_against_force
from updamp.pictures.style import FORMATS, style_key
from updamp.pictures.variants import PeakPoint
from updamp.workflow.products import Products
from updamp.workflow.quick_look import is_drawn, peaks_followed, responses_note
from updamp.workflow.run import Run

Integers = NDArray[np.int64]

FROM = 0.95  # of the free blade's first frequency: where the picture without damper begins
BLADE_SHAPES = 4  # of the free blade, beside the two coupled ones


def by_mode(products: Products) -> Mapping[str, Sequence[ResponseCurve]]:
    modes: dict[str, list[ResponseCurve]] = {}
    for curve in products.curves:
        if len(curve.product):
            modes.setdefault(curve.product.mode, []).append(curve.product)
    return modes


def curve_keys(products: Products, mode: str) -> list[str]:
    return [curve.stamp.key for curve in products.curves if curve.product.mode == mode]


def stability_keys(products: Products, mode: str) -> list[str]:
    return [entry.stamp.key for entry in products.stability if entry.product.mode == mode]


# --- pictures: file, what it is made of, what draws it. Those by matplotlib first: they need no system libraries ---


@dataclass(frozen=True, eq=False)
class Picture:
    """name: of the file; sources: what it is made of; beside: endings of further formats that `draw` writes"""

    name: str
    sources: Sequence[str]
    draw: Callable[[Path], None]
    beside: Sequence[str] = ()


def plot(name: str, sources: Sequence[str], draw: Callable[[Path], None]) -> Picture:
    """By matplotlib, as the style says"""
    return Picture(f"pictures/{name}.png", [*sources, style_key()], draw, FORMATS)


def pictures(run: Run, products: Products) -> list[Picture]:
    if not run.options.pictures:
        return []
    return [
        one for one in (*_plots(run, products), *_renderings(products)) if is_drawn(Path(one.name).name, run.options)
    ]


def _plots(run: Run, products: Products) -> list[Picture]:
    drawn: list[Picture] = []
    contacts, rest = products.mesh.product.contacts, products.static_contact
    if rest is not None:
        draw = partial(faces.pressure, contacts=contacts, rest=rest.product)
        drawn.append(plot("pressure", [rest.stamp.key], draw))
    modes = by_mode(products)
    for mode, curves in modes.items():
        drawn += _of_mode(run, products, mode, curves)
    if modes:
        ends = [lowest_and_highest(curves) for curves in modes.values()]
        places = [(curve, peak_place(run, curve)) for curves in ends for curve in curves]
        keys = [key for mode in modes for key in curve_keys(products, mode)]
        draw_motion = partial(kinematics.damper_kinematics, rig=run.rig, curves=places)
        drawn.append(plot("damper_motion", keys, draw_motion))
    return drawn


def _of_mode(run: Run, products: Products, mode: str, curves: Sequence[ResponseCurve]) -> list[Picture]:
    keys, point = curve_keys(products, mode), run.rig.response_point
    finer = [curve for curve in products.finer if curve.product.mode == mode and len(curve.product)]
    followed = next((entry for entry in products.resonances if entry.product.mode == mode), None)
    peaks = [peak for (of, _), peak in peaks_followed(products).items() if peak is not None and of == mode]
    note = responses_note(products.left, run.options)

    def draw_responses(path: Path) -> None:
        others, alone = [curve.product for curve in finer], blades_alone(run, products, curves)
        detached = {force: found.branches for force, found in products.detached_of(mode).items()}
        stability = products.stability_of(mode)
        drawn = response.Responses(mode, point, curves, others, stability, alone, detached, peaks, note)
        response.frequency_responses(path, drawn)

    def draw_states(path: Path) -> None:
        states = states_at_peaks(run, products, curves)
        faces.contact_states(path, run.rig, products.mesh.product.contacts, mode, states)

    def draw_loops(path: Path) -> None:
        curve = max(curves, key=lambda one: one.force)
        title = f"{mode} at {curve.force:g} N: force loops at the peak"
        force_loops.force_loops(path, title, loops_at_peak(run, products, curve))

    def draw_resonance(path: Path) -> None:
        peaks = [PeakPoint(curve.force, *curve.peak(point), curve.complete) for curve in curves]
        resonance_against_force(path, mode, followed.product if followed else None, peaks)

    sources = [point, *keys, *(curve.stamp.key for curve in finer), *stability_keys(products, mode)]
    sources += [entry.stamp.key for entry in products.detached if entry.product.mode == mode]
    sources += [repr(peak) for peak in peaks] + ([note] if note else [])
    return [
        plot(f"frf_{mode}", sources, draw_responses),
        plot(f"contact_states_{mode}", [point, *keys], draw_states),
        plot(f"force_loops_{mode}", [point, *keys], draw_loops),
        plot(f"resonance_{mode}", [point, *keys, followed.stamp.key if followed else ""], draw_resonance),
    ]


def _renderings(products: Products) -> list[Picture]:
    mesh = products.mesh
    drawn: list[Picture] = [
        Picture("pictures/mesh.png", [mesh.stamp.key], lambda path: bodies.mesh(path, mesh.product)),
    ]
    if products.finite_elements is not None:
        keys = [entry.stamp.key for entry in (products.finite_elements, products.coupled_check) if entry is not None]
        drawn.append(Picture("pictures/modes.png", keys, lambda path: panel(path, mode_shapes(products))))
        first = 1 if products.coupled_check is not None else 0  # IP where the coupled modes are known
        drawn.append(Picture("pictures/mode.gif", keys, lambda path: animation(path, mode_shapes(products)[first])))
    return drawn


def mode_shapes(products: Products) -> tuple[ModeShape, ...]:
    """The stuck OOP and IP modes where the coupled check was made, then the first of the free blade."""
    mesh, result = products.mesh.product, products.finite_elements
    assert result is not None, "mode shapes come with the finite elements"
    shapes = []
    if products.coupled_check is not None:
        check, left = products.coupled_check.product, mirrored_mesh(mesh.blade)
        for mode, number in (("OOP", check.out_of_phase), ("IP", check.in_phase)):
            shape = check.shapes[mode]
            all_three = ((mesh.blade, "blade_right"), (left, "blade_left"), (mesh.damper, "damper"))
            parts = tuple((body, shape[name]) for body, name in all_three)
            shapes.append(ModeShape(f"{mode}, stuck: {check.full[number]:.1f} Hz", parts))
    blade = result.product
    for i, shape in enumerate(blade.blade_shapes[:BLADE_SHAPES]):
        shapes.append(
            ModeShape(f"free blade, mode {i + 1}: {blade.blade_frequencies[i]:.1f} Hz", ((mesh.blade, shape),))
        )
    return tuple(shapes)


def lowest_and_highest(curves: Sequence[ResponseCurve]) -> list[ResponseCurve]:
    """Of the force levels: where the contacts hardly slip, and where they do most; one where there is one."""
    ordered = sorted(curves, key=lambda curve: curve.force)
    return [ordered[0], *ordered[1:][-1:]]


def blades_alone(run: Run, products: Products, curves: Sequence[ResponseCurve]) -> response.LinearResponse:
    """The response without damper, which is linear, from below the free blade's first resonance to the curves' end."""
    assert products.finite_elements is not None, "a curve has a reduced model"
    model = nonlinear_model(run, products)
    free, first = model.free, float(products.finite_elements.product.blade_frequencies[0])
    ends = [float(f) for curve in curves for f in (curve.frequency.min(), curve.frequency.max())]
    low, high = min(*ends, FROM * first), max(ends)
    spread = first * np.sinh(np.linspace(-8, 8, 161)) / np.sinh(8) * (1 - FROM)  # closest at the resonance
    frequency = np.unique(np.concatenate([np.linspace(low, high, 200), first + spread]))
    frequency = frequency[(frequency >= low) & (frequency <= high)]
    row, column = (np.array([free.row(name)]) for name in (run.rig.response_point, model.excitation))
    receptance = [free.receptance(2 * np.pi * float(f), row, column)[0, 0] for f in frequency]
    return response.LinearResponse(frequency, np.array(receptance))


def peak_place(run: Run, curve: ResponseCurve) -> int:
    return int(abs(curve.receptance(run.rig.response_point)).argmax())


def states_at_peaks(run: Run, products: Products, curves: Sequence[ResponseCurve]) -> dict[float, Integers]:
    """force -> (n_patches,) ContactState over a period at the point of largest response."""
    model = nonlinear_model(run, products)
    element = DAMPER_MODELS[run.rig.damper_model].element_of_patch(products.mesh.product.contacts)
    return {curve.force: _states(run, model, curve)[element] for curve in curves}


def loops_at_peak(run: Run, products: Products, curve: ResponseCurve) -> list[ForceLoop]:
    """Of nine places on the faces (fem/contact_places.py)."""
    model, contacts = nonlinear_model(run, products), products.mesh.product.contacts
    element = DAMPER_MODELS[run.rig.damper_model].element_of_patch(contacts)
    states, i, loops = _states(run, model, curve), peak_place(run, curve), []
    model = in_its_harmonics(model, curve)
    for place in NINE_PLACES:
        number = int(element[nearest_patch(contacts, place)])
        w, state = 2 * np.pi * float(curve.frequency[i]), ContactState(int(states[number]))
        loops.append(loop_of_contact(model, curve.displacement[i], w, number, place.name, state))
    return loops


def _states(run: Run, model: RigModel, curve: ResponseCurve) -> Integers:
    """(n_elements,)"""
    i = peak_place(run, curve)
    system = in_its_harmonics(model, curve).system
    return contact_states(system, curve.displacement[i], 2 * np.pi * float(curve.frequency[i]))


def in_its_harmonics(model: RigModel, curve: ResponseCurve) -> RigModel:
    """The harmonics of a curve may have been chosen for it."""
    setting = with_orders(setting_of(model.system), curve.orders)
    return replace(model, harmonics=Harmonics(setting.orders), time_samples=setting.time_samples)


def nonlinear_model(run: Run, products: Products) -> RigModel:
    assert products.finite_elements is not None, "a curve has a reduced model"
    assert products.static_contact is not None, "a curve has a rest state"
    return rig_model(products.finite_elements.product.reduced, products.static_contact.product, run.rig)

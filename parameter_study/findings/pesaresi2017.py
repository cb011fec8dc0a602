"""The fifteen findings of Pesaresi et al. (2017), in this project's words, with what counts as met."""

from updamp.parameter_study.findings.contact_stiffness import stiffness_matters_when_low
from updamp.parameter_study.findings.contacts import edges_slip_first, loops_from_centre_to_edge
from updamp.parameter_study.findings.damper_models import film_is_best_in_oop, uniform_rises_in_ip
from updamp.parameter_study.findings.damper_motion import mean_position_moves, translates_in_oop_rolls_in_ip
from updamp.parameter_study.findings.finding import Finding
from updamp.parameter_study.findings.harmonics import mean_position_softens_ip
from updamp.parameter_study.findings.levels import (
    above_the_test,
    ip_softens_with_jumps,
    oop_peak_falls,
    oop_stays_coupled,
)
from updamp.parameter_study.findings.pressure import (
    asymmetry_matters_at_low_force,
    lowest_at_80_20,
    uneven_pressure_damps,
)

PESARESI_2017: tuple[Finding, ...] = (
    Finding(1, "OOP: large drop of the peak from 0.096 to 17 N, the resonance shifts by less than 1 %", "Fig. 7a",
            "peak at least 40 % lower, resonance within 1 %", oop_peak_falls),
    Finding(2, "OOP at 17 N: blades still coupled, centre of the damper still stuck", "Figs 7a, 18",
            "resonance nearer to the low-force one than to the free blade's; both centres (A2, B2) stuck",
            oop_stays_coupled),
    Finding(3, "IP: slight drop of the peak, strong softening with jumps, 393 down into 360-390 Hz", "Fig. 7b",
            "peak at 17 N up to 25 % below that at 0.096 N; resonance at 0.916 to 0.992 of it; some sweep jumps",
            ip_softens_with_jumps),
    Finding(4, "Damper: pure translation in OOP; rolling in IP, bottom corners in antiphase", "Figs 8b, 17",
            "at 0.096 N: rotation below a tenth of translation in OOP; corners within 30 degrees of antiphase in IP",
            translates_in_oop_rolls_in_ip),
    Finding(5, "OOP at 3.84 N: the more uneven the pressure, the more damping; up to 65 % in amplitude", "Fig. 10a",
            "peaks fall from 50/50 to 100/0 throughout; the lowest 50 to 80 % below 50/50", uneven_pressure_damps),
    Finding(6, "OOP at 17 N: less sensitive; lowest peak at 80/20", "Fig. 10b",
            "spread of the peaks below that at 3.84 N; lowest at 80/20", lowest_at_80_20),
    Finding(7, "Asymmetric pressure matters most at low force; little frequency change", "Fig. 10c, d",
            "change of the OOP peak against 50/50 larger at 3.84 N than at 17 N; resonance within 1 %",
            asymmetry_matters_at_low_force),
    Finding(8, "Kt = Kn from 5e3 to 1e7 N/mm3: about 1 % in frequency, mostly at the low end; lower stiffness, larger "
            "amplitude", "Fig. 11",
            "OOP at 3.84 N, uniform pressure: 0.5 to 2 % in all, more than half of it below 6e4; no peak 1 % above "
            "that of a lower stiffness, that at 1e7 below that at 5e3",
            stiffness_matters_when_low),
    Finding(9, "IP: harmonics 1-3 and 1-10 nearly coincide; 0-3 differs and softens", "Fig. 12b",
            "at 9.6 N, uniform pressure: 0-3 resonates below 1-3, and 1-10 differs from 1-3 by less than a fifth of "
            "that",
            mean_position_softens_ip),
    Finding(10, "Near the IP resonance the mean position moves: damper up, blades apart", "Fig. 13",
            "at 17 N: both positive at the resonance, and more than twice what they are at the ends of the window",
            mean_position_moves),
    Finding(11, "Model against test: OOP frequency about 1 % high, IP about 8 % high", "Fig. 15",
            "at 0.096 N: OOP above 435.9 Hz by up to 2 %, IP above 393 Hz by 6 to 10 %", above_the_test),
    Finding(12, "OOP peak against force: sharp first drop, then almost constant; lumped damper too high, above all at "
            "low force; uniform pressure too little damping; film pressure best", "Fig. 16a",
            "film: 70 % of the drop by 3.84 N; from 0.96 N on uniform and lumped above film, lumped most at 3.84 N or "
            "below",
            film_is_best_in_oop),
    Finding(13, "IP peak against force: more or less constant at large force; uniform pressure rises at medium force; "
            "lumped damper stays linear", "Fig. 16b",
            "film within 15 % from 9.6 to 17 N; uniform rises by more than 2 % at a medium level; lumped within 5 %",
            uniform_rises_in_ip),
    Finding(14, "Contacts stick, slip, separate or never touch; edges slip first; stuck area of IP at 0.96 N gone at "
            "higher force", "Fig. 18",
            "OOP: at the first level with slip it is farther from the centres than stick; IP: stuck area at 0.96 N, "
            "below 1 % at 17 N", edges_slip_first),
    Finding(15, "Force loops: stuck in the centre, slip then separation at edges; A1 and A3 have tangential forces in "
            "phase and normal forces in antiphase", "Fig. 19",
            "at 17 N: centres stuck in OOP, some edge contact separates; in one of the modes first harmonics of A1 "
            "and A3 within 45 degrees of phase (tangential) and of antiphase (normal)", loops_from_centre_to_edge),
)  # fmt: skip

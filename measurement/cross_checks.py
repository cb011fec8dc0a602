"""Whether the tables of measurement.toml fit together: each problem a line that names the key and the remedy."""

from collections.abc import Mapping, Sequence

from updamp.measurement.measurement import near
from updamp.measurement.tables import ChannelTable, RunTable, force_channel_of, level_in_si

Channels = Mapping[str, ChannelTable]


def problems_of(channels: Channels, runs: Sequence[RunTable], excitation: str) -> list[str]:
    """Empty where there are none."""
    problems = [*_force_problems(channels, excitation), *_convention_problems(channels)]
    if any(channel.quantity == "force" for channel in channels.values()):  # whose level the runs state
        problems += [*_run_problems(channels, runs), *_order_problems(runs)]
    return problems


def _force_problems(channels: Channels, excitation: str) -> list[str]:
    forces = [name for name, channel in channels.items() if channel.quantity == "force"]
    if not forces:
        return [
            'channels: none has quantity = "force"; responses are held against it: add a table [channels.force] with '
            'quantity = "force", point, direction and unit (and recorded = false where its level alone is known)'
        ]
    if len(forces) > 1:
        return [f"channels: {', '.join(forces)} are all forces; keep the one at the excitation"]
    if len(channels) == 1:
        return ["channels: there is a force only; add the response's"]
    point = channels[forces[0]].model_point
    if point != excitation:
        return [f'channels.{forces[0]}.point: the force is at "{point}", excitation = "{excitation}"; make them one']
    return []


def _convention_problems(channels: Channels) -> list[str]:
    """Where some state what others leave open, nobody knows whether the others were forgotten."""
    lines = []
    for key in ("amplitude", "noise"):
        named = {name: getattr(channel, key) for name, channel in channels.items()}
        for name, channel in channels.items():
            if channel.quantity == "force" and (key == "noise" or not channel.recorded):  # then it is the run's level
                named.pop(name)
        open_ones = [name for name, value in named.items() if value is None]
        if open_ones and len(open_ones) < len(named):
            lines.append(
                f"channels.{open_ones[0]}.{key}: missing, while other channels state it (mixed conventions); "
                f"state it for all of them or for none"
            )
    labels = [channel.label or name for name, channel in channels.items()]
    for label in sorted({label for label in labels if labels.count(label) > 1}):
        lines.append(f'channels: more than one has label = "{label}"; every channel needs its own')
    return lines


def _order_problems(runs: Sequence[RunTable]) -> list[str]:
    """Of all runs or of none, and each of an assembly at its own place."""
    if all(run.taken is None for run in runs):
        return []
    lines = []
    for i, run in enumerate(runs):
        if run.taken is None:
            lines.append(f"runs[{i}].taken: missing, and others have it; number all runs as they were made, or none")
            continue
        for j, other in enumerate(runs[:i]):
            if run.taken == other.taken and (run.repeat == other.repeat or None in (run.repeat, other.repeat)):
                lines.append(f"runs[{i}].taken = {run.taken}: so has runs[{j}] of the same assembly; number them anew")
    return lines


def _run_problems(channels: Channels, runs: Sequence[RunTable]) -> list[str]:
    lines = []
    first: dict[str, RunTable] = {}
    listed: set[str] = set()
    for i, run in enumerate(runs):
        here = f"runs[{i}]"
        for key, names in (("channels", run.channels or ()), ("held_channel", (run.held_channel,))):
            for name in names:
                if name is not None and name not in channels:
                    lines.append(f'{here}.{key} = "{name}": no such channel; {near(name, channels)}')
        if not channels[force_channel_of(channels)].recorded and (run.held != "force" or run.level is None):
            lines.append(f'{here}.held: the force was not recorded, so it is the level: held = "force" and level')
        if not any(line.startswith(f"{here}.held") for line in lines):
            lines += _level_problems(channels, run, here)
        other = first.setdefault(run.name, run)
        for key in ("mode", "held", "level", "sweep", "held_channel"):
            if getattr(other, key) != getattr(run, key):
                lines.append(
                    f'{here}.{key} = "{getattr(run, key)}": another run of the name "{run.name}" has '
                    f'"{getattr(other, key)}"; runs of one name are repeats of one test, give the others another name'
                )
        same = run.model_dump_json()
        if same in listed:
            lines.append(f'{here}.name = "{run.name}": the very same run is listed twice; take one of them out')
        listed.add(same)
    return lines


def _level_problems(channels: Channels, run: RunTable, here: str) -> list[str]:
    try:
        level_in_si(channels, run)
    except ValueError as error:
        return [f'{here}.level = "{run.level}": {error}']
    return []

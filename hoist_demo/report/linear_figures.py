"""Figure of linear models along the trip: frequencies, poles, and Bode plots.

Bode plots are drawn with and without the balance ropes.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hoist_demo.design.linear_model import LinearModel, UndampedModes
from hoist_demo.design.reduced_model import ALPHA, SLOWEST
from hoist_demo.report.figures import ACCENTS, REFERENCE, STYLE, save_figure

LAYOUT: Literal["constrained"] | None = "constrained"  #: Layout of the figure.
_CHANNELS = (
    ("rate", "Torque to sheave speed", "[rad/s per N m]"),
    ("pull_left", "Torque to head-rope pull, left", "[N per N m]"),
)
#: Frequencies at equal distances: 0.03 Hz in a band of 2 Hz, where alpha / 2 pi is 0.02 Hz.
_EVEN_STEPS = 70
_EVEN_RATIOS = 30  #: Frequencies at equal ratios.
_COLOURS = "viridis"  #: Of heights, and of the hoist's share.


def write_modes_figure(
    models: Sequence[LinearModel],
    modes: Sequence[UndampedModes],
    without: LinearModel,
    band: float,
    path: Path,
) -> Path:
    """Draw models of all heights and their modes.

    ``without`` is the hoist at a middle height without ropes.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(10.0, 9.0), layout=LAYOUT)
        axes = figure.subplots(3, 2)
        _frequencies(figure, axes[0, 0], models, modes, band)
        _poles(axes[0, 1], models, modes)
        # even steps show each peak that is as wide as alpha, even ratios the slopes below
        frequencies = np.union1d(
            np.linspace(SLOWEST, band, _EVEN_STEPS), np.geomspace(SLOWEST, band, _EVEN_RATIOS)
        )
        names = [name for name, _, _ in _CHANNELS]
        some = [models[k] for k in sorted({0, len(models) // 2, len(models) - 1})]
        curves: list[tuple[LinearModel, str, dict[str, Any]]] = [
            (m, f"at {m.at:g}", {"color": _colour(m.at)}) for m in some
        ]
        curves.append(
            (without, f"no balance rope, at {without.at:g}", {"color": REFERENCE, "ls": "--"})
        )
        for model, label, style in curves:
            # narrow peaks as a record of some 1/alpha shows them
            G = model.selected(("torque_command",), names).response(
                ALPHA + 2j * np.pi * frequencies
            )[:, :, 0]
            for one, (gain, phase) in zip(G.T, axes[1:].T, strict=True):
                gain.loglog(frequencies, np.abs(one), label=label, lw=1.2, **style)
                phase.semilogx(frequencies, np.degrees(np.unwrap(np.angle(one))), lw=1.2, **style)
        for (_, title, unit), (gain, phase) in zip(_CHANNELS, axes[1:].T, strict=True):
            gain.set_title(title)
            gain.set_ylabel(unit)
            phase.set_ylabel("[degrees]")
            phase.set_xlabel("frequency [Hz]")
        axes[1, 0].legend()
        return save_figure(figure, path)


def _colour(at: float) -> tuple[float, ...]:
    return tuple(matplotlib.colormaps[_COLOURS](0.9 * at))


def _frequencies(
    figure: Figure,
    ax: Axes,
    models: Sequence[LinearModel],
    modes: Sequence[UndampedModes],
    band: float,
) -> None:
    for model, modes_here in zip(models, modes, strict=True):
        order = np.argsort(modes_here.shares[0])
        share = modes_here.shares[0][order]
        size = 3.0 + 30.0 * share
        at = np.full(share.size, model.at)
        drawn = ax.scatter(
            at,
            modes_here.frequencies[order],
            size,
            share,
            cmap="Blues",
            vmin=-0.4,
            vmax=1.0,
            lw=0.0,
        )
    bar = figure.colorbar(drawn, ax=ax, label="hoist's share of the kinetic energy")
    bar.ax.set_ylim(0.0, 1.0)  # the map begins below, for a share of 0 is to be seen
    ax.set_title("Natural frequencies along the trip")
    ax.set_xlabel("height of the left conveyance over the travel")
    ax.set_ylabel("[Hz]")
    ax.set_ylim(0.0, band)


def _poles(ax: Axes, models: Sequence[LinearModel], modes: Sequence[UndampedModes]) -> None:
    """Draw the upper poles of the modes.

    Those with hardly any damping lie on the imaginary axis.
    """
    for k, (model, modes_here) in enumerate(zip(models, modes, strict=True)):
        real = -2 * np.pi * modes_here.frequencies * modes_here.damping
        if k in (0, len(models) // 2, len(models) - 1):
            label = f"at {model.at:g}"
        else:
            label = None
        ax.plot(real, modes_here.frequencies, "x", ms=4.0, color=_colour(model.at), label=label)
    ax.axvline(0.0, color=ACCENTS[3], lw=0.8)
    ax.set_title("Poles of the modes, upper half")
    ax.set_xlabel("real part [1/s]")
    ax.set_ylabel("imaginary part / 2 pi [Hz]")
    ax.legend()

"""Layout of figures whose panels stand in rows and columns: margins from the widths of their texts.

Heights are constants; the widths of tick labels and legends are measured once. The layouts of
matplotlib measure the ticks of all panels for each of them, several times.
"""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_POINT = 1.0 / 72.0  # inch
WIDTH = 8.0  #: Width of a figure [inch].
_PITCH = 1.75  #: Height of a panel of a stack with its title [inch].
_ALL_PANELS = 0.5  #: Height of a stack beside its panels [inch].
_BORDER = 0.08  #: Distance of texts from the edges of the figure [inch].
_AXIS_LABEL = 14.0 * _POINT  #: Width or height of an axis label with its distance [inch].
_TICK = 7.0 * _POINT  #: Length of a tick, and the distance of its label from it [inch].
BELOW = 0.42  #: Height of tick labels and of the axis label below a panel [inch].
ABOVE = 0.36  #: Height of a title, and of a factor of the tick labels below it [inch].
TITLE_PAD = 6.0  #: Distance of a title from its panel [points].
_FACTOR = 10.0  #: Height of a factor of the tick labels, above its axis [points].


def stacked_panels(titles: Sequence[str]) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels above one another over a common axis."""
    height = _PITCH * len(titles) + _ALL_PANELS
    figure = Figure(figsize=(WIDTH, height))
    axes: list[Axes] = list(figure.subplots(len(titles), 1, sharex=True, squeeze=False)[:, 0])
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title)
    return figure, axes


def lay_out_stack(figure: Figure, axes: Sequence[Axes], more_above: float = 0.0) -> None:
    """Place the panels of ``stacked_panels``, drawn and with legends beside them.

    ``more_above`` is the height of texts between the first panel and its title [points].
    """
    height = figure.get_figheight()
    gaps = ABOVE * (len(axes) - 1)
    panel = (height - BELOW - ABOVE - more_above * _POINT - gaps) / len(axes)
    figure.subplots_adjust(
        bottom=BELOW / height,
        top=1.0 - (ABOVE + more_above * _POINT) / height,
        hspace=ABOVE / panel,
    )
    left = widest_labels(figure, axes)
    right = max(_legend_width(figure, ax) for ax in axes) + _BORDER
    figure.subplots_adjust(left=left / WIDTH, right=1.0 - right / WIDTH)
    place_labels(figure, axes, left)


def widest_labels(figure: Figure, axes: Sequence[Axes]) -> float:
    """Return the width that the axes' y-labels and widest tick labels take beside them [inch].

    Titles of axes whose tick labels have a factor above them move up.
    """
    renderer = _renderer(figure)
    widest = 0.0
    for ax in axes:
        for label in ax.get_yticklabels():
            widest = max(widest, label.get_window_extent(renderer).width)
        if ax.yaxis.get_major_formatter().get_offset():
            title = ax.get_title(loc="left")
            ax.set_title(title, pad=TITLE_PAD + _FACTOR)
    return _BORDER + _AXIS_LABEL + widest / figure.dpi + _TICK


def place_labels(figure: Figure, axes: Sequence[Axes], left: float) -> None:
    """Place the y-labels at the outer edge of the width ``left`` [inch] beside their axes."""
    label = left - _BORDER - _AXIS_LABEL + 3.0 * _POINT
    for ax in axes:
        width = ax.get_position().width * figure.get_figwidth()
        ax.yaxis.set_label_coords(-label / width, 0.5)


def _legend_width(figure: Figure, ax: Axes) -> float:
    """Return the width of the legend beside a panel [inch]."""
    legend = ax.get_legend()
    if legend is None:
        return 0.0
    width: float = legend.get_window_extent(_renderer(figure)).width
    return width / figure.dpi


def _renderer(figure: Figure) -> RendererBase:
    canvas = figure.canvas
    if not isinstance(canvas, FigureCanvasAgg):
        canvas = FigureCanvasAgg(figure)
    renderer: RendererBase = canvas.get_renderer()  # type: ignore[no-untyped-call]
    return renderer


def legend(ax: Axes) -> None:
    """Draw the legend beside the panel, where it hides nothing."""
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)

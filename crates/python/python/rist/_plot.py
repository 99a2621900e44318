"""`.plot()` of the classes: axes of matplotlib where it is there, else a `rist.Picture`, which needs nothing."""

import base64
import html
import math
import pathlib

from ._rist import Error


class Picture:
    """Charts as SVG, used if matplotlib is not installed. A notebook shows the charts; `save` writes them."""

    def __init__(self, charts):
        self.charts = dict(charts)

    def save(self, path) -> None:
        """Writes one chart to a file, or several charts into a directory, which is created if it does not exist."""
        path = pathlib.Path(path)
        if len(self.charts) == 1 and path.suffix:
            [svg] = self.charts.values()
            path.write_text(svg, encoding="utf-8")
            return
        path.mkdir(parents=True, exist_ok=True)
        for name, svg in self.charts.items():
            (path / name).write_text(svg, encoding="utf-8")

    def __repr__(self) -> str:
        return f"<rist.Picture: {', '.join(self.charts)}>"

    def _repr_html_(self) -> str:
        # As images, so that a chart's style stays its own.
        def image(name, svg):
            data = base64.b64encode(svg.encode()).decode()
            words = html.escape(name.removesuffix(".svg").replace("_", " "))
            shown = f'<img alt="{words}" style="width: 100%" src="data:image/svg+xml;base64,{data}">'
            return f'<figure style="max-width: 640px; margin: 0 0 1em"><figcaption>{words}</figcaption>{shown}</figure>'

        return "\n".join(image(name, svg) for name, svg in self.charts.items())


Picture.__module__ = "rist"

MEASURED, PREDICTED, LEFT = "#b4b4b4", "#1f77b4", "#d62728"


def _pyplot():
    try:
        import matplotlib.pyplot as pyplot
    except ImportError:
        return None
    return pyplot


def _panels(pyplot, count, title, height=1.9):
    figure, axes = pyplot.subplots(count, 1, sharex=True, squeeze=False, layout="constrained", figsize=(8, 0.8 + height * count))
    figure.suptitle(title, x=0.02, ha="left")
    return axes[:, 0]


def estimate(found, log):
    """Measured and identified torques, joint by joint; of an estimate of experiments its parameters."""
    has_series = found.joints["coordinate"] and found.to_dict().get("options") is not None
    pyplot = _pyplot()
    if pyplot is None:
        return _charts(found._pictures(log) if has_series else {}, "torque", "residual")
    if not has_series:
        return _parameters(pyplot, found)
    series = found.predict(log)
    # Logs one behind the other, with a gap between them.
    shown = series if isinstance(series, list) else [series]
    names, units = found.model.coordinates, found.joints["unit"]
    axes = _panels(pyplot, len(names), "torque: measured, identified, residual")
    for k, axis in enumerate(axes):
        start = 0.0
        for one in shown:
            t = one["t"] - one["t"][0] + start
            measured, predicted = one["measured"][:, k], one["predicted"][:, k]
            # Wide and pale, so that it is seen below a line that is on it.
            axis.plot(t, measured, color=MEASURED, linewidth=3.5, label="measured")
            axis.plot(t, predicted, color=PREDICTED, linewidth=0.9, label="identified")
            axis.plot(t, measured - predicted, color=LEFT, linewidth=0.7, label="left")
            start = t[-1] + 1.0
        axis.set_ylabel(f"{names[k]}, {units[k]}")
        axis.margins(x=0)
    lines, labels = axes[0].get_legend_handles_labels()
    axes[0].legend(lines[:3], labels[:3], loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, fontsize="small", frameon=False)
    axes[-1].set_xlabel("time, s")
    return axes


def _parameters(pyplot, found):
    """Values with two standard deviations, divided by the absolute value: a bar that crosses zero is not significant."""
    finite = [(n, v, s) for n, v, s in zip(found.names, found.values, found.sigma) if math.isfinite(v) and math.isfinite(s) and v]
    figure, axis = pyplot.subplots(layout="constrained", figsize=(7, 1.0 + 0.22 * len(finite)))
    rows = range(len(finite))
    axis.errorbar([math.copysign(1.0, v) for _, v, _ in finite], rows, xerr=[2 * s / abs(v) for _, v, s in finite], fmt="o", capsize=2)
    axis.axvline(0.0, color=MEASURED, linewidth=0.8)
    axis.set_yticks(rows, [name for name, _, _ in finite])
    axis.invert_yaxis()
    axis.set_xlim(-3, 3)
    axis.set_xlabel("value and two deviations, per size of the value")
    return figure.axes


def motion(found):
    """Positions and velocities over time, with the limits of the positions."""
    pyplot = _pyplot()
    if pyplot is None:
        return _charts(found._pictures(), "motion_position", "motion_velocity")
    head, *lines = found.trajectory().splitlines()
    names = head.split(",")
    columns = dict(zip(names, zip(*(map(float, line.split(",")) for line in lines))))
    joints = found.to_dict()["joints"]
    axes = _panels(pyplot, len(joints), "motion" if found.proven else "motion, NOT proven to keep its limits")
    for axis, joint in zip(axes, joints):
        name = joint["coordinate"]
        axis.plot(columns["t"], columns[f"q_{name}"], color=PREDICTED, label="position, rad (m)")
        axis.plot(columns["t"], columns[f"dq_{name}"], color=MEASURED, linewidth=0.8, label="velocity, rad/s (m/s)")
        position = joint["limits"].get("position")
        inside = axis.get_ylim()
        for limit in position or []:
            if inside[0] - 1.0 < limit < inside[1] + 1.0:
                axis.axhline(limit, color=LEFT, linewidth=0.8, linestyle="--")
        axis.set_ylabel(name)
        axis.margins(x=0)
    axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize="small", frameon=False)
    axes[-1].set_xlabel("time, s")
    return axes


def validation(found):
    """Relative errors by joint and by log."""
    groups = [
        ("by joint", list(zip(found.joints["coordinate"], found.joints["relative"]))),
        ("by log", [(pathlib.PurePath(name).name, error) for name, error in found.logs.items()]),
    ]
    groups = [(what, [(name, 100 * x) for name, x in bars]) for what, bars in groups if bars]
    pyplot = _pyplot()
    if pyplot is None:
        title = f"error of the torque, {100 * found.total:.2g} % in all"
        charts = found._pictures()
        bars = [(f"{what}.svg".replace(" ", "_"), _bars(f"{title}, {what}", bars, " %")) for what, bars in groups]
        return Picture(charts or bars)
    figure, axes = pyplot.subplots(1, len(groups), squeeze=False, layout="constrained", figsize=(8, 3.2))
    figure.suptitle(f"error of the torque: {100 * found.total:.2g} % in all")
    for axis, (what, bars) in zip(axes[0], groups):
        axis.barh([name for name, _ in bars], [x for _, x in bars], height=0.5, color=PREDICTED)
        axis.invert_yaxis()
        axis.set_xlabel(f"{what}, %")
    return axes[0]


def log_check(found):
    """The slope of each joint, which is 1 where log and description agree."""
    joints = found.joints
    bars = [(name, slope) for name, slope in zip(joints["coordinate"], joints["slope"]) if slope is not None]
    title = "log and description: " + (f"{len(found.findings)} contradicted" if found.findings else "nothing is contradicted")
    pyplot = _pyplot()
    if not bars:
        raise Error("the description has no inertial parameters, or the log no torques: there are no slopes to draw")
    if pyplot is None:
        return Picture([("slopes.svg", _bars(title + "; slope of each joint, 1 where they agree", bars, ""))])
    shares = [share or 0.0 for share, slope in zip(joints["share"], joints["slope"]) if slope is not None]
    figure, axis = pyplot.subplots(layout="constrained", figsize=(7, 1.2 + 0.35 * len(bars)))
    drawn = axis.barh([name for name, _ in bars], [x for _, x in bars], color=PREDICTED)
    for bar, share in zip(drawn, shares):
        # As in the table: a joint that the description hardly explains is drawn pale.
        bar.set_alpha(1.0 if share > 0.5 else 0.35)
    axis.axvline(1.0, color=LEFT, linewidth=1.0, linestyle="--")
    axis.invert_yaxis()
    axis.set_xlabel("measured torque per torque of the description (pale: little evidence)")
    axis.set_title(title)
    return figure.axes


def _charts(charts, *kinds):
    """What the page draws, of these kinds where it has them. There may be nothing."""
    charts = dict(charts)
    charts = {name: svg for name, svg in charts.items() if name.startswith(kinds)} or charts
    if not charts:
        raise Error("there is nothing to draw without matplotlib: pip install matplotlib")
    return Picture(charts)


def _bars(title, bars, unit):
    """Horizontal bars as SVG."""
    longest = max((abs(x) for _, x in bars), default=0.0) or 1.0
    lines = [f'<text x="8" y="20" font-weight="bold">{html.escape(title)}</text>']
    for k, (name, x) in enumerate(bars):
        y = 36 + 24 * k
        lines.append(f'<text x="172" y="{y + 13}" text-anchor="end">{html.escape(name)}</text>')
        lines.append(f'<rect x="180" y="{y}" width="{340 * abs(x) / longest:.1f}" height="16" fill="{PREDICTED}"/>')
        lines.append(f'<text x="{188 + 340 * abs(x) / longest:.1f}" y="{y + 13}">{x:.3g}{unit}</text>')
    height = 44 + 24 * len(bars)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 {height}" width="640" height="{height}" '
        f'font-family="sans-serif" font-size="13"><rect width="100%" height="100%" fill="white"/>{"".join(lines)}</svg>\n'
    )

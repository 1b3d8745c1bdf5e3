"""Probes and a Keyphasor of a run that is known: files as a data logger writes them."""

import numpy as np

TABLE = """[measured]
file = "run.csv"
time = "t"
keyphasor = "KPH"
{more}
[[measured.probe]]
column = "X"
angle = {angles[0]}
sensitivity = "7.87 V/mm"
[[measured.probe]]
column = "Y"
angle = {angles[1]}
sensitivity = "7.87 V/mm"
"""


def turns_of(time, speeds):
    """Turns of a shaft whose speed rises evenly from speeds[0] to speeds[1] Hz."""
    rise = (speeds[1] - speeds[0]) / time[-1]
    return speeds[0] * time + 0.5 * rise * time**2


def pulses_of(turns, events=1, share=0.06):
    """-10 V in the notch, which begins at every whole event, else 0, as sharp as an edge is between two samples."""
    phase = (turns * events + 0.5) % 1.0 - 0.5
    step = np.maximum(np.gradient(turns * events), 1e-12)  # 0 at rest
    return -10.0 * np.clip(np.minimum(phase, share - phase) / step + 0.5, 0.0, 1.0)


def volts(r, angles):
    """What two probes of 7.87 V/mm give, looking in directions of so many degrees from y towards z."""
    return [7.87e3 * (r.real * np.cos(a) + r.imag * np.sin(a)) for a in np.deg2rad(angles)]


def written(folder, time, r, pulses, angles=(45.0, 135.0), more="", parted=",", head="t,X,Y,KPH"):
    """run.csv and run.toml in a folder; returns the path of run.toml. Decimal commas where ";" parts."""
    rows = np.column_stack([time, *volts(r, angles), pulses])
    text = "\n".join(parted.join(f"{value:.9g}" for value in row) for row in rows)
    text = text.replace(".", ",") if parted == ";" else text
    (folder / "run.csv").write_text(head.replace(",", parted) + "\n" + text + "\n")
    path = folder / "run.toml"
    path.write_text(TABLE.format(angles=angles, more=more))
    return path

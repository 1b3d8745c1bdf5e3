"""Lines on a run that two probes measured, read as text and judged by the third engine's run from the same start."""

import re
import tempfile
from pathlib import Path

import numpy as np

import rsc
from answers_spectra import line_near, synchronous_line
from answers_witness import NUM, SAID
from product_lines import size_of
from rsc.measured.virtual import write_measured
from rsc.show.words.answer import answer

DOUBT = 0.15  # turns by which a limit may be missed
LINE_DOUBT = 0.1  # by which a share of a line may be: windows of different shape
TURNS, SENSE, PARTS = 3.0, 2.0, 8  # of docs/users/measured.md: least turns, least turns of a sense, parts of a window
BINS = 3.0  # around minus the rotor speed that may be the ellipse of unequal supports
SILENT = "two probes see neither contact nor force"


def of_measured(result, signals):
    """(topic, text, [what is false, "" or "skipped"]) of a run of rsc.simulate, measured and compared; signals: of the third
    engine's run, at its only contact."""
    with tempfile.TemporaryDirectory() as folder:
        report = rsc.compare(result.scene, rsc.read_measured(write_measured(result, Path(folder) / "run.toml")))
    seen = _Seen(report, signals)
    judges = {"motion": seen.of_motion, "frequency": seen.of_frequency, "vibration": seen.of_vibration, "model": seen.of_model,
              "force": seen.of_force, "signals": seen.of_signals, "not told": seen.of_silence,
              "check": seen.of_check}  # fmt: skip
    for topic, text in answer(report):
        judge = judges.get(topic)
        yield f"measured {topic}", text, list(judge(text)) if judge else ["skipped"]


def _backward_line(own):
    """(bins of the window, share of the root mean square about the mean) of the largest backward line."""
    motion = own - own.mean()
    lines = np.abs(np.fft.fft(motion, 8 * len(motion)))[4 * len(motion) :] / len(motion)
    return (lines.argmax() - len(lines)) / 8.0, lines.max() / np.sqrt(np.mean(np.abs(motion) ** 2))


class _Seen:
    """The windows of a measured report beside the third engine's samples."""

    def __init__(self, report, signals):
        self.report, self.signals, self.fall = report, signals, report.fall
        half = 0.5 * self.fall.window
        self.parts = [signals.part(middle - half, middle + half) for middle in self.fall.time]
        self.rate = 1.0 / np.diff(signals.time[:2])[0]

    def kinds(self, i):
        """What probes may see in window i, by the definitions of docs/users/measured.md."""
        part = self.parts[i]
        own, shaft = self.signals.rotor[part], float(np.ptp(self.signals.shaft[part]))
        turn = np.unwrap(np.angle(own - own.mean())) / (2.0 * np.pi)
        edges = np.linspace(0, len(turn) - 1, PARTS + 1).round().astype(int)
        turned, whole = np.diff(turn[edges]), abs(turn[-1] - turn[0])
        if max(whole, shaft) < TURNS - DOUBT:
            return {"not resolved"}
        told = set()
        if whole < SENSE + DOUBT or (turned.min() < DOUBT and turned.max() > -DOUBT):
            told |= {"turns neither way"}
        if whole > SENSE - DOUBT and turned.max() < DOUBT:
            line, share = _backward_line(own)  # a whirl has at least half
            told |= {"backward whirl"} if share > 0.5 - LINE_DOUBT else set()
            # the ellipse of a rotor without contact turns backward at minus its speed
            told |= {"turns neither way"} if share < 0.5 + LINE_DOUBT or abs(line + shaft) < BINS + 1.0 else set()
        if whole > SENSE - DOUBT and turned.min() > -DOUBT:
            off = abs(whole - shaft) - max(0.75, 0.01 * shaft)
            told |= {"turns with the shaft"} if off < DOUBT else set()
            told |= {"turns forward, not with the shaft"} if off > -DOUBT else set()
        return told | ({"not resolved"} if max(whole, shaft) < TURNS + DOUBT else set())

    def of_motion(self, text):
        """The kind of every window, and that each is named."""
        own = [str(kind) for kind in self.report.features.kind]
        for i, kind in enumerate(own):
            if kind not in self.kinds(i):
                yield f"window {i}, called {kind}, is {' or '.join(sorted(self.kinds(i)))}"
        for kind in set(own):
            if kind not in text:
                yield f"windows that are {kind} are not told"

    def whirling(self):
        """Numbers of the windows on a whirl."""
        return [i for i in range(len(self.fall.time)) if self.report.features.on_whirl(i)]

    def of_frequency(self, text):
        """The range of the lines of the whirl."""
        match = re.match(rf"{NUM}(?: to {NUM})? Hz", text)
        if match is None:
            yield "unreadable"
            return
        low, high = float(match[1]), float(match[2] or match[1])
        found = []
        for i in self.whirling():
            wanted = float(self.report.features.frequency[i])
            found.append(line_near(self.signals.rotor[self.parts[i]], self.rate, wanted, 0.0)[0])
        bin_width = 1.0 / self.fall.window
        ends = np.nanmin(found), np.nanmax(found)
        for said, right in zip((low, high), ends, strict=True):
            if not abs(said - right) <= 0.3 * bin_width + 0.005 * abs(right):
                yield f"third engine: {ends[0]:.5g} to {ends[1]:.5g} Hz"

    def of_vibration(self, text):
        """Peak to peak, the largest distance from the resting position, the largest line at the rotor speed."""
        match = re.match(rf"up to {SAID} pk-pk; up to {SAID} \({NUM} gaps of the scene\) .*; the line .* up to {SAID}$", text)
        if match is None:
            yield "unreadable"
            return
        size, away, once = (size_of(match[k], match[k + 1]) for k in (1, 4, 8))
        pieces = [self.signals.rotor[part] for part in self.parts]
        most = max(max(np.ptp(piece.real), np.ptp(piece.imag)) for piece in pieces)
        lines = [synchronous_line(piece, 2.0 * np.pi * self.signals.shaft[part])
                 for piece, part in zip(pieces, self.parts, strict=True)]  # fmt: skip
        if abs(size / most - 1.0) > 0.05:
            yield f"pk-pk {most:.4g} m"
        largest = abs(self.signals.rotor).max()
        if abs(away / largest - 1.0) > 0.05:
            yield f"distance {largest:.4g} m"
        value, doubt = max(lines)
        if abs(once - value) > 0.05 * value + 2.0 * min(doubt, value):
            yield f"line at the rotor speed {value:.4g} m"

    def of_model(self, text):
        """How many windows agree with a whirl of the scene, by the third engine's lines."""
        match = re.search(r"(\d+) of (\d+) windows agree in frequency", text)
        if match is None:
            yield "skipped"
            return
        agree = 0
        for i in self.whirling():
            predicted = self.report.windows[i].frequency.predicted
            line = line_near(self.signals.rotor[self.parts[i]], self.rate, predicted, 0.0)[0]
            agree += abs(line / predicted - 1.0) < 0.0075
        if int(match[2]) != len(self.whirling()) or agree < int(match[1]):
            yield f"{agree} of {len(self.whirling())} agree"

    def of_force(self, text):
        """The force of the model against that of the motion, which the probes did not see."""
        match = re.search(rf"presses with {SAID}(?: to {SAID})?", text)
        if match is None:
            yield "" if text.startswith("unknown: ") else "unreadable"
            return
        low = size_of(match[1], match[2])
        high = size_of(match[4], match[5]) if match[4] else low
        forces = [self.signals.force[self.parts[i]].mean() for i in self.whirling()]
        if "may the force" not in text and not 0.85 * low <= np.median(forces) <= 1.15 * high:
            yield f"the motion presses with {np.median(forces):.4g} N"

    def of_signals(self, text):
        """Nothing is wrong with signals without noise or faults."""
        yield "" if text.startswith("nothing wrong") else "skipped"

    def of_silence(self, text):
        """What probes cannot tell."""
        yield "" if text.startswith(SILENT) else "unreadable"

    def of_check(self, text):
        """The counts of the check line against the windows."""
        whirl = [window.frequency.verdict for window in self.report.windows]
        own = [verdict for verdict in whirl if verdict not in ("no whirl", "not resolved")]
        counted = re.search(r"(\d+) of (\d+) windows? with a backward line", text)
        said = (int(counted[1]), int(counted[2])) if counted else (0, 0)
        if said != (own.count("agrees"), len(own)):
            yield "the counts are not those of the windows"

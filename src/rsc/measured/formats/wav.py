"""WAV: whole numbers and floats of any width that SciPy reads; chunks other than its head and its data are passed over."""

import io
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rsc.errors import one_line
from rsc.files.memory import Memory
from rsc.measured.channel import MOST_COLUMNS, Channel, NoColumns, Recording

MAGIC = b"RIFF", b"RIFX", b"RF64"
_PASSED_OVER = r"Chunk \(non-data\) not understood"  # PEAK, bext, cue, iXML, id3 ...


def recognises(head: bytes) -> bool:
    """Whether a file begins as WAV files do."""
    return head.startswith(MAGIC)


def open_wav(content: bytes) -> Recording:
    """Its channels, over its largest number, called by their numbers from "1" on."""
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", wavfile.WavFileWarning)  # cut off, for example
            warnings.filterwarnings("ignore", _PASSED_OVER, wavfile.WavFileWarning)
            rate, data = wavfile.read(io.BytesIO(content))
    except Exception as error:  # it raises nearly anything for a damaged file
        raise NoColumns(f"cannot be read as WAV: {one_line(error)[:100]}") from None
    data = data.reshape(len(data), -1) if data.size else np.empty((0, 0))
    if not rate > 0 or not data.size or data.shape[1] > MOST_COLUMNS:
        raise NoColumns("a WAV file without samples, or with too many channels")
    largest = {"u": 128.0, "i": float(2 ** (8 * data.itemsize - 1)), "f": 1.0}[data.dtype.kind]
    middle = 128.0 if data.dtype.kind == "u" else 0.0

    def read(wanted: Sequence[int], memory: Memory) -> list[NDArray[np.float64]]:
        return [(data[:, i] - middle) / largest for i in wanted]

    channel = Channel((), len(data), start=0.0, interval=1.0 / float(rate))
    return Recording((channel,) * data.shape[1], read, full_scale=True)

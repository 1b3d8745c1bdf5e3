"""Memory and disk that a run will need, known before it starts."""

import math
import shutil
from pathlib import Path

from rsc.errors import DataError, SolverError
from rsc.measure.stretches import COLUMNS
from rsc.operating_system import free_memory, process_memory
from rsc.results.result_format import CHECKPOINT_ROWS, CHUNK_ROWS, columns_of, series_of

# of the free memory or disk
LARGEST_SHARE = 0.8
# while blocks are joined they are held twice
COPIES = 2
# a block as the kernel writes it, in physical coordinates, interleaved for the file, and temporaries: measured with tracemalloc
BLOCK_COPIES = 3.5
# measured: the compiled kernel and the libraries it is loaded with; compiling it takes some 250 MB more
KERNEL_BYTES = 50e6
# measured: the analysis, spectra in pieces and the page of a report, with their libraries, whatever the length of its run
REPORT_BYTES = 180e6
# axes, attributes, chunk indices and HDF5's own: 33 to 46 kB measured
FILE_FRAME = 40e3


# of a checkpoint beside its vectors: counts, sums and the running stretch; stretches of a run at most, whose facts are kept
STATE_BYTES, MOST_STRETCHES = 520, 4096


def row_bytes(scene):
    """Bytes of one sample: time, real series and, of every coordinate, a complex displacement and perhaps a velocity."""
    return (1 + len(series_of(scene))) * 8 + 16 * sum(columns_of(scene).values())


def sample_bytes(scene, share=1.0):
    """Bytes of a share of the samples of a run."""
    return _rows(scene, share) * row_bytes(scene)


def _rows(scene, share):
    return int(share * scene.drive.duration * scene.output.rate) + 1


def file_bytes(scene, chunk_time, share=1.0):
    """Bytes of the result file of a run with a share of its samples, whose checkpoints are about `chunk_time` seconds apart."""
    rows, per_row = _rows(scene, share), row_bytes(scene)
    chunks = -(-rows // CHUNK_ROWS)
    arrays = 1 + len(series_of(scene)) + sum(count > 0 for count in columns_of(scene).values())
    checkpoints = min(scene.drive.duration / chunk_time, rows) + 1
    per_checkpoint = 64 * (scene.rotor.n_coordinates + scene.stator.n_coordinates) + STATE_BYTES + 8 * arrays
    checkpoint_bytes = -(-checkpoints // CHECKPOINT_ROWS) * CHECKPOINT_ROWS * per_checkpoint
    stretches = min(MOST_STRETCHES, 1.0 + 0.5 * scene.drive.duration * scene.drive.fastest)
    stretch_bytes = 8 * stretches * (len(COLUMNS) + 1)
    return int(chunks * (CHUNK_ROWS * per_row + 4 * arrays) + checkpoint_bytes + stretch_bytes + FILE_FRAME)


def memory_bytes(scene, buffer=None, share=1.0):
    """Bytes that a run needs besides its kernel: for a share of its samples, or the buffer (bytes) of a run to a file."""
    return int(COPIES * sample_bytes(scene, share) if buffer is None else BLOCK_COPIES * buffer)


def peak_memory(needed):
    """Peak of this process in bytes once it takes `needed` more; only `needed` where the system does not tell the rest."""
    held, peak = process_memory()
    return max(peak or 0, (held or 0) + needed)


def free_disk(path):
    """Bytes that are free where a file is to be, or None when the system does not tell."""
    try:
        return shutil.disk_usage(Path(path).resolve().parent).free
    except OSError:
        return None


def refuse_too_large(scene, path=None, buffer=None, chunk_time=None):
    """Refuse a run that would take more memory or disk than there is, before its kernel is compiled.

    Parameters
    ----------
    scene : Scene
    path : str or Path, optional
        File of the run; with it buffer (bytes of its samples held at a time) and chunk_time (s, as `file_bytes`).

    Raises
    ------
    SolverError
        More than 80 % of the free memory, with what would fit.
    DataError
        More than 80 % of the free disk, with what would fit.
    """
    memory, free = KERNEL_BYTES + memory_bytes(scene, buffer), free_memory()
    if free is not None and memory > LARGEST_SHARE * free:
        shortage = f"the run of {scene.source} needs {size_text(memory)} of memory and {size_text(free)} are free"
        if path is not None:
            raise SolverError(f"{shortage}: model rotor and stator with fewer coordinates")
        less = _less(scene, lambda share: KERNEL_BYTES + memory_bytes(scene, share=share) <= LARGEST_SHARE * free)
        raise SolverError(f"{shortage}: stream the samples to a file (path, or rsc run -o){', or ' if less else ''}{less}")
    if path is None:
        return
    disk, free_bytes = file_bytes(scene, chunk_time), free_disk(path)
    if free_bytes is not None and disk > LARGEST_SHARE * free_bytes:
        less = _less(scene, lambda share: file_bytes(scene, chunk_time, share) <= LARGEST_SHARE * free_bytes)
        shortage = f"the run needs {size_text(disk)} of disk and {size_text(free_bytes)} are free"
        raise DataError(path, f"{shortage}: {less or 'make room'}")


def foresee(scene, path=None, buffer=None, chunk_time=None):
    """One line for people on the memory and disk of a run, once its kernel is compiled; parameters as `refuse_too_large`.

    The memory is the peak of the whole process, with that of compiling.
    """
    text = f"this run will hold {size_text(peak_memory(memory_bytes(scene, buffer)))} of memory"
    if path is None:
        return text
    free_bytes = free_disk(path)
    text += f" and write {size_text(file_bytes(scene, chunk_time))} to {path}"
    return text + (f" ({size_text(free_bytes)} free)" if free_bytes is not None else "")


def foresee_report(scene, path=None):
    """One line for people on the memory of a run with its report, before either begins; parameters as `refuse_too_large`."""
    samples = 0 if path is not None else memory_bytes(scene)
    return f"run and report will hold at most {size_text(peak_memory(KERNEL_BYTES + REPORT_BYTES + samples))} of memory"


def refuse_too_many(scenes):
    """SolverError when the runs of many scenes would hold more than 80 % of the free memory, with how many would fit."""
    free, samples = free_memory(), COPIES * sum(sample_bytes(scene) for scene in scenes)
    if free is None or KERNEL_BYTES + samples <= LARGEST_SHARE * free:
        return
    fit = int(len(scenes) * max(LARGEST_SHARE * free - KERNEL_BYTES, 0.0) / samples)
    less = f"run some {fit} at a time, or lower output.rate" if fit else "stream each to a file (rsc.simulate with path)"
    needed = f"the runs of {len(scenes)} scenes need {size_text(KERNEL_BYTES + samples)} of memory"
    raise SolverError(f"{needed} and {size_text(free)} are free: {less}")


def _less(scene, fits):
    """The change of a scene that leaves the largest share of its samples that fits; "" when none does."""
    low, high = 0.0, 1.0
    if not fits(low):
        return ""
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    rate = _down(low * scene.output.rate)
    if rate > 4.0 * scene.drive.fastest:
        return f"lower output.rate to {rate:.3g}"
    return f"shorten drive.duration to {_down(low * scene.drive.duration):.3g} s"


def _down(value):
    """The value rounded down to three digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2) if value > 0.0 else 1.0
    return math.floor(value / unit) * unit


def size_text(count):
    unit, name = (1e9, "GB") if count >= 1e9 else (1e6, "MB")
    return f"{count / unit:.1f} {name}"

"""What a run will need before it starts: memory for its samples."""

from pathlib import Path

from rsc.errors import SolverError

# of what is free
LARGEST_SHARE = 0.8
# while blocks are joined they are held twice
COPIES = 2


def sample_bytes(scene):
    """Bytes of all samples of a run: five real series and one complex displacement a coordinate."""
    rows = int(scene.drive.duration * scene.output.rate) + 1
    return rows * (5 * 8 + 16 * (scene.rotor.n_coordinates + scene.stator.n_coordinates))


def free_memory():
    """Bytes of memory that are free, or None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:")), None)


def refuse_more_than_memory(scene):
    """SolverError when the samples would take more than 80 % of the free memory, with what would fit."""
    needed, free = COPIES * sample_bytes(scene), free_memory()
    if free is None or needed <= LARGEST_SHARE * free:
        return
    rate = scene.output.rate * LARGEST_SHARE * free / needed
    raise SolverError(
        f"the samples of {scene.source} need {needed / 1e9:.1f} GB of memory and {free / 1e9:.1f} GB are free: "
        f"stream them to a file (path, or rsc run -o), or lower output.rate to {rate:.3g}"
    )

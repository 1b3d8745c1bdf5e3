"""What a result file holds, by name, and its checksums."""

import errno
import hashlib
import re
import zlib

import h5py
import numpy as np

from rsc.errors import DataError, one_line
from rsc.operating_system import explained

FORMAT = "rsc-result-7"
# energies of a ledger that only runs with rotating damping have, with coefficients that follow the speed, a torque or states
FED = ("turned_in", "followed_in", "driven_in", "control_in")
CHUNK_ROWS = 4096
CHECKPOINT_ROWS = 16

# name -> (unit, description)
SERIES = {
    "speed": ("Hz", "rotor speed"),
    "normal_force": ("N", "contact normal force F_N"),
    "friction_force": ("N", "contact friction force mu sigma F_N"),
    "tangential_velocity": ("m s-1", "tangential velocity of the contact deflection, without the rotor's own turning"),
}
# of runs whose drive has a torque, beside these
TURNED = {"angle": ("turns", "rotation angle of the rotor, whole turns left out")}
# of runs with a race that turns
RACES = {"race_speed": ("Hz", "speed of the inner race, 0 at a contact without one")}
NOT_ALWAYS = TURNED | RACES
# of several contacts a column each
OF_CONTACT = ("normal_force", "friction_force", "tangential_velocity", *RACES)
# complex, stored with a last dimension (y, z), a column for each coordinate; velocities only of runs whose scene asks for them
MOTIONS = {
    "rotor": ("m", "rotor displacements"),
    "stator": ("m", "stator displacements"),
    "rotor_velocity": ("m s-1", "rotor velocities"),
    "stator_velocity": ("m s-1", "stator velocities"),
    "rotor_states": ("1", "first-order states of the rotor"),
    "stator_states": ("1", "first-order states of the stator"),
}
DISPLACEMENTS, STATES = ("rotor", "stator"), ("rotor_states", "stator_states")
# array -> name of the axis that numbers its columns, for other readers
AXES = {name: f"{name}_coordinate" for name in DISPLACEMENTS} | {name: name.removesuffix("s") for name in STATES}
HEAD = ("format", "title", "scene", "versions", "checksum")  # attributes of every file; a run that has ended adds its Summary
CHECKPOINT = "checkpoint/"
# a row of numbers a block of samples: where it ends, then the CRC-32 of its part of every array. HDF5's own Fletcher sums do not
# tell zeros from ones in 16 bits, and take a block of zeros, sums and all, for a whole one
BLOCKS = "blocks/checksums"
UNWRITTEN = -1  # what arrays of whole numbers hold where nothing was written
# facts of the stretches of a run, a row each: `rsc.measure.stretches.COLUMNS`, then the CRC-32 of those
STRETCHES = "stretches/facts"


def motions_of(scene):
    """Names of the motions that a run of a scene keeps; of a body without coordinates they have no columns."""
    states = tuple(name for name in STATES if _columns(scene, name))
    moving = tuple(name for name in MOTIONS if name not in STATES) if scene.output.velocities else DISPLACEMENTS
    return moving + states


def series_of(scene):
    """name -> (unit, description) of the real series that a run of a scene keeps."""
    races = any(contact.race_inertia is not None for contact in scene.contacts)
    return SERIES | (TURNED if scene.drive.inertia is not None else {}) | (RACES if races else {})


def moving_body(name):
    """What moves: "rotor", "stator", or the states of one of them."""
    return name.removesuffix("_velocity")


def _columns(scene, name):
    """Number of coordinates, or of states, of a motion."""
    body = getattr(scene, name.partition("_")[0])
    return body.n_states if name in STATES else body.n_coordinates


def columns_of(scene):
    """name -> number of coordinates of every motion in runs of a scene, 0 for one that is not kept."""
    kept = motions_of(scene)
    return {name: _columns(scene, name) if name in kept else 0 for name in MOTIONS}


def put(attrs, values):
    """Write attributes, texts among them with a fixed length: those of any length go to a heap without a checksum."""
    for name, value in values.items():
        if isinstance(value, str):
            text = value.encode()
            attrs.create(name, np.bytes_(text), dtype=h5py.string_dtype("utf-8", max(len(text), 1)))
        else:
            attrs[name] = value


def digest(values):
    """SHA-256 of the values of a file's attributes."""
    digest = hashlib.sha256()
    for name in sorted(set(values) - {"checksum"}):
        value = values[name]
        digest.update(name.encode() + b"=" + (value.encode() if isinstance(value, str) else np.asarray(value).tobytes()) + b"\n")
    return digest.hexdigest()


def sample_arrays(file):
    """Names of a file's (or dict's) arrays over time, in the order of their checksums."""
    return [name for name in ("time", *SERIES, *NOT_ALWAYS, *MOTIONS) if name in file]


def checksum(values):
    """CRC-32 of a block of an array as it is stored."""
    return zlib.crc32(np.ascontiguousarray(values))


def with_sums(rows):
    """Facts (n, k) of stretches with the CRC-32 of each row behind it."""
    sums = np.array([checksum(row) for row in rows], dtype=float)
    return np.column_stack([rows, sums]) if len(rows) else np.empty((0, rows.shape[1] + 1))


def without_sums(rows):
    """Facts (n, k) as they were handed to `with_sums`; ValueError where a row was changed."""
    facts = np.ascontiguousarray(rows[:, :-1])
    if any(checksum(row) != total for row, total in zip(facts, rows[:, -1], strict=True)):
        raise ValueError("the facts of a stretch are damaged")
    return facts


def checkpoint_checksum(arrays):
    """CRC-32 over all arrays (name -> array) of one checkpoint."""
    total = 0
    for name in sorted(set(arrays) - {"checksum"}):
        total = zlib.crc32(np.ascontiguousarray(arrays[name]), total)
    return total


def block_ends(ends, rows):
    """0 and the rows at which the blocks end; ValueError unless they increase, to no more than there are."""
    ends = np.concatenate([[0], ends])
    if ends.min() < 0 or ends.max() > rows or np.any(np.diff(ends) <= 0):
        raise ValueError("its blocks contradict each other")
    return ends


def locked(values):
    """An array that cannot be written any more, nor be made writable again."""
    values.flags.writeable = False
    return values[:]


def whole_blocks(file):
    """(n, 1 + arrays) rows of the blocks of samples: where each ends, its checksums. The array is made longer before a row is
    written, so that a fault may leave a last row without numbers: it does not count."""
    marks = file[BLOCKS][...]
    return marks[:-1] if len(marks) and marks[-1, 0] == UNWRITTEN else marks


def checked(file, name, column=None, rows=None):
    """The samples of one array (or of one coordinate of it) in all blocks that are whole, or in the rows (first, last, exclusive)
    of them, which cannot be written; ValueError when one is damaged."""
    data, marks, i = file[name], whole_blocks(file), 1 + sample_arrays(file).index(name)
    ends = block_ends(marks[:, 0], data.shape[0])
    first, last = (0, int(ends[-1])) if rows is None else rows
    values = np.empty((last - first, *(data.shape[1:] if column is None else data.shape[2:])))
    block = int(np.searchsorted(ends, first, side="right")) - 1
    while block < len(marks) and ends[block] < last:
        begin = ends[block]
        after = max(block + 1, int(np.searchsorted(ends, begin + CHUNK_ROWS, side="right")) - 1)  # small blocks together
        piece = data[begin : ends[after]]
        if name in MOTIONS and not np.isfinite(piece).all():  # forces may overflow, the motion stops before
            raise ValueError(f"{name} has a sample that is not finite")
        for k in range(block, after):
            if checksum(piece[ends[k] - begin : ends[k + 1] - begin]) != marks[k, i]:
                raise ValueError(f"{name} is damaged between samples {ends[k]} and {ends[k + 1]}")
        inside = slice(max(begin, first), min(ends[after], last))
        piece = piece[inside.start - begin : inside.stop - begin]
        values[inside.start - first : inside.stop - first] = piece if column is None else piece[:, column]
        block = after
    return locked(values)


class Guard:
    """Turns the failures of a block of file operations into one DataError."""

    def __init__(self, path, problem, error=DataError):
        self._path, self._problem, self._error = path, problem, error

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        # h5py reports a full disk or damage as OSError, RuntimeError, KeyError or ValueError, by the layer that met it
        if kind is not None and issubclass(kind, (OSError, RuntimeError, KeyError, ValueError, TypeError)):
            raise self._error(self._path, f"{self._problem} ({_reason(error)})") from None


def _reason(error):
    """In one line: what the operating system said where HDF5 tells that among addresses and sizes, else its first line."""
    if isinstance(error, OSError) and error.errno is None and error.strerror:
        return one_line(error.strerror)  # rsc's own
    if isinstance(error, OSError) and error.errno == errno.ELOOP:
        return "it is a link"
    lines, system = str(error).strip().splitlines(), re.search(r"error message = '([^']+)'", str(error))
    told = system[1] if system else getattr(error, "filename", None) and explained(error)
    return one_line(told.lower() if told else lines[0] if lines else type(error).__name__)

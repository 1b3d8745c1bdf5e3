"""`off`: the time at which a bearing is switched off, for the drop of a rotor."""

from rsc.scene.keys.keys import RawTable
from rsc.scene.keys.readers import Number, as_list

OFF = Number("time", above=0.0)
OFF_MEANING = "Time at which it is switched off, for the drop of a rotor."


def off_time(table: RawTable, key: str, raw: object) -> float | None:
    """Read the time in s at which a bearing of the rotor is switched off, which must lie within the run; None if it stays."""
    if raw is None:
        return None
    if as_list(raw) is not None:
        table.refuse(key, raw, "one time: a bearing is switched off once")
    off: float = OFF.read(table, key, raw)
    if table.name.startswith("stator"):
        table.refuse(key, raw, "left out: only bearings of the rotor can be switched off")
    if table.duration and not off < table.duration:
        table.refuse(key, raw, f"before the end of the run at {table.duration:g} s")
    return off

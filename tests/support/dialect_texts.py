"""Texts of data loggers, oscilloscopes and spreadsheets, and LabVIEW's .lvm: dialects of dialects.py."""

import io

import numpy as np

from dialects import RATE, TIME, Table, by, dialect, signals

T = by(time="t")


def rows(columns, parted=",", fmt="%.9g", comma=False, end="\n", tail=""):
    """The rows of columns as a text."""
    out = io.StringIO()
    np.savetxt(out, np.column_stack(columns), fmt=fmt, delimiter=parted)
    text = out.getvalue()
    text = text.replace(".", ",") if comma else text
    return text.replace("\n", tail + end)


def usual(**how):
    return rows([TIME, *signals().values()], **how)


def text(name, head, table=None, file="run.csv", encoding="utf-8", before=b"", refused="", told="", **how):
    """A dialect of a head and the usual rows."""

    def write(path):
        path.write_bytes(before + (head + usual(**how)).encode(encoding))

    dialect(name, file, table or Table(more=T), refused, told)(write)


text("CSV, commas", "t,X,Y,KPH\n")
text("CSV, semicolons", "t;X;Y;KPH\n", parted=";")
text("CSV, semicolons and decimal commas", "t;X;Y;KPH\n", parted=";", comma=True)
text("CSV, tabs", "t\tX\tY\tKPH\n", parted="\t")
text("CSV, tabs and decimal commas", "t\tX\tY\tKPH\n", parted="\t", comma=True)
text("text, blanks", "t X Y KPH\n", parted=" ", file="run.txt")
text("text, blanks that align", "   t         X         Y       KPH\n", parted="  ", fmt="%15.7e", file="run.dat")
text("CSV without a head", "", Table(("2", "3", "4"), by(time="1")))
text("CSV without a head and times, by the rate", "", Table(("2", "3", "4"), by(rate=RATE)))
text("CSV with the mark of UTF-8", "t,X,Y,KPH\n", encoding="utf-8-sig")
text("CSV in UTF-16", "t,X,Y,KPH\n", encoding="utf-16")
text("CSV in UTF-16, the other order", "t,X,Y,KPH\n", encoding="utf-16-be", before=b"\xfe\xff")
text("CSV in UTF-16 without a mark", "t,X,Y,KPH\n", encoding="utf-16-le")
text("CSV of Windows", "t,X,Y,KPH\r\n", end="\r\n")
text("CSV of an old Macintosh", "t,X,Y,KPH\r", end="\r")
text("text of numpy.savetxt", "# t X Y KPH\n", parted=" ", file="run.txt")
text("CSV of numpy.savetxt", "# t,X,Y,KPH\n")
text("text with a head of MATLAB", "% recorded on the bench\n% t\tX\tY\tKPH\n", parted="\t")
text("CSV of a logger with its settings", "Logger;7\nRange;10;V\nFilter;off\n\nt;X;Y;KPH\n", parted=";")
text("CSV with numbers in its preamble", "Samples,8000\nRate,4000,Hz\nGains,1,1,1\nt,X,Y,KPH\n")
text("CSV with a date before it", "2024-05-01,10:00:00\nt,X,Y,KPH\n")
text("CSV of Excel with its separator", "sep=;\nt;X;Y;KPH\n", parted=";")
text("CSV with quoted names", '"t","X","Y","KPH"\n')
text("CSV with names that hold the separator", '"t","X, front","Y, front","KPH"\n', Table(("X, front", "Y, front", "KPH"), T))
text("CSV with a separator at the ends of lines", "t;X;Y;KPH;\n", parted=";", tail=";")
text("CSV with a blank line under the names", "t,X,Y,KPH\n\n")
text("CSV with units in a row", "t,X,Y,KPH\ns,um,um,V\n", Table(more=T, unit=""))
text("CSV with units in a row, in brackets", "t,X,Y,KPH\n(s),(um),(um),(V)\n\n", Table(more=T, unit=""))
text("CSV with units behind the names", "t [s],X [um],Y [um],KPH [V]\n", Table(more=T, unit=""))
text(
    "CSV with units behind the names, called with them",
    "t (s),X (um),Y (um),KPH\n",
    Table(("X (um)", "Y (um)", "KPH"), by(time="t (s)"), ""),
)
text("CSV with units behind a stroke", "t / s;X / µm;Y / µm;KPH / V\n", Table(more=T, unit=""), parted=";", encoding="latin-1")
text("CSV with a micro sign of UTF-8", "t;X;Y;KPH\ns;µm;µm;V\n", Table(more=T, unit=""), parted=";")
text("CSV with a unit that nobody knows", "t,X,Y,KPH\ns,EU,EU,V\n", told="EU")
text("CSV whose unit the table contradicts", "t,X,Y,KPH\ns,mm,mm,V\n", refused="left out, or the 0.001 m")
text("CSV of accelerations", "t,X,Y,KPH\ns,m/s^2,m/s^2,V\n", refused="acceleration in m/s^2")
text("CSV of velocities", "t,X,Y,KPH\ns,mm/s,mm/s,V\n", refused="velocity in mm/s")
text(
    "CSV of lengths with a sensitivity",
    "t,X,Y,KPH\ns,um,um,V\n",
    Table(more=T, unit='sensitivity = "8 V/mm"'),
    refused="states um",
)
text("CSV without any unit", "t,X,Y,KPH\n", Table(more=T, unit=""), refused="no unit")
text("CSV with names on two lines", "time,probe,probe,pulse\nt,X,Y,KPH\n")


def columns(name, head, made, table=None, refused="", told="", **how):
    """A dialect of a head and other columns than the usual ones."""

    def write(path):
        path.write_text(head + rows(made(), **how), encoding="utf-8")

    dialect(name, "run.csv", table or Table(more=T), refused, told)(write)


def with_time(t, *more):
    return [t, *signals().values(), *more]


columns("CSV in milliseconds", "t,X,Y,KPH\n(ms),(um),(um),(V)\n\n", lambda: with_time(1e3 * TIME), Table(more=T, unit=""))
columns(
    "CSV in microseconds, said by the table",
    "t,X,Y,KPH\n",
    lambda: with_time(1e6 * TIME),
    Table(more=by(time="t", time_unit="1 us")),
)
columns(
    "CSV in milliseconds, contradicted",
    "t (ms),X,Y,KPH\n",
    lambda: with_time(1e3 * TIME),
    Table(more=by(time="t", time_unit="1 s")),
    "0.001 s",
)
columns(
    "CSV with units behind low lines",
    "t_ms,x_um,y_um,KPH\n",
    lambda: with_time(1e3 * TIME),
    Table(("x", "y_um", "KPH"), by(time="t_ms"), ""),
)
columns(
    "CSV with times since a moment",
    "t,X,Y,KPH\nmilliseconds since 2024-05-01,um,um,V\n",
    lambda: with_time(1e3 * TIME),
    Table(more=T, unit=""),
)
columns(
    "CSV of an oscilloscope",
    "x-axis,1,2,3\nsecond,Volt,Volt,Volt\n",
    lambda: with_time(TIME),
    Table(("1", "2", "3"), by(time="x-axis"), 'sensitivity = "1 V/um"'),
)
columns(
    "CSV with heads above each other",
    "Name,X,Y,KPH\nUnit,um,um,V\nFilter,10,10,10\n",
    lambda: with_time(TIME),
    Table(more=by(time="Name"), unit=""),
)
columns("CSV that begins before the trigger", "t,X,Y,KPH\n", lambda: with_time(TIME - 0.75))
columns("CSV with times of a day", "t,X,Y,KPH\n", lambda: with_time(36000.0 + TIME), fmt="%.10g")
columns("CSV with an index of pandas", ",t,X,Y,KPH\n", lambda: [np.arange(len(TIME)), *with_time(TIME)])
columns("CSV with the head 0,1,2,3", "0,1,2,3\n", lambda: with_time(TIME), Table(("1", "2", "3"), by(time="0")))
columns(
    "CSV with times for each channel",
    "t,X,t,Y,t,KPH\n",
    lambda: [c for s in signals().values() for c in (TIME, s)],
    Table(more=by(time="1")),
)
columns("CSV with two columns of one name", "t,X,X,KPH\n", lambda: with_time(TIME), Table(("X", "3", "KPH"), T), "2 columns 'X'")
columns(
    "CSV with millivolts",
    "t,X,Y,KPH\ns,mV,mV,V\n",
    lambda: [TIME, 8.0 * signals()["X"], 8.0 * signals()["Y"], signals()["KPH"]],
    Table(more=T, unit='sensitivity = "8 V/mm"'),
)
columns(
    "CSV with a speed in rpm", "t,X,Y,n\ns,um,um,rpm\n",
    lambda: [TIME, signals()["X"], signals()["Y"], 60.0 * (40.0 + 2.5 * TIME)],
    Table(("X", "Y", "n"), T, "", "speed"), told="no Keyphasor",
)  # fmt: skip


def _other(name, make, table=None, refused="", told="", file="run.csv"):
    dialect(name, file, table or Table(more=T), refused, told)(lambda path: path.write_text(make(), encoding="utf-8"))


def _rounded(rate, decimals):
    kept = slice(None, None, int(RATE / rate))
    lines = zip(TIME[kept], *(values[kept] for values in signals().values()), strict=True)
    return "t,X,Y,KPH\n" + "".join(f"{t:.{decimals}f},{x:.6f},{y:.6f},{k:.3f}\n" for t, x, y, k in lines)


def _stamped(stamp):
    return "".join(f"{stamp(t)},{x:.6f},{y:.6f},{k:.3f}\n" for t, x, y, k in zip(TIME, *signals().values(), strict=True))


def _quoted(value):
    return '"' + f"{value:.7f}".replace(".", ",") + '"'


def _all_quoted():
    return "".join(",".join(map(_quoted, row)) + "\n" for row in zip(TIME, *signals().values(), strict=True))


def _footed():
    return "t,X,Y,KPH\n" + usual() + "Total,8000,rows,\n"


_other("CSV with rounded times", lambda: _rounded(4000.0, 3), told="rounded to 3 decimals")
_other("CSV with times rounded a little", lambda: _rounded(4000.0, 4), told="rounded to 4 decimals")
_other(
    "CSV with times of a date",
    lambda: "when,X,Y,KPH\n" + _stamped(lambda t: f"2024-05-01T10:00:0{t:.5f}"),
    Table(more=by(rate=RATE)),
)
_other("CSV with times of a clock", lambda: "when,X,Y,KPH\n" + _stamped(lambda t: f"10:00:0{t:.5f}"), Table(more=by(rate=RATE)))
_other(
    "CSV with times of a clock asked for",
    lambda: "when,X,Y,KPH\n" + _stamped(lambda t: f"10:00:0{t:.5f}"),
    Table(more=by(time="when")),
    "is not 4 numbers",
)
_other("CSV with decimal commas in quotation marks", lambda: "t,X,Y,KPH\n" + _all_quoted())
_other("CSV with a word behind each row", lambda: "t,X,Y,KPH,state\n" + usual(tail=",ok"))
_other("CSV with decimal commas and commas", lambda: "t,X,Y,KPH\n" + usual(comma=True), refused="no column 'X'")
_other("CSV with a line at its end", _footed, refused="is not 4 numbers")
_other("CSV with a row too long", lambda: "t,X,Y,KPH\n" + usual().replace("\n0.5,", "\n0,5,"), refused="fields")
_other(
    "text with exponents of Fortran",
    lambda: "t X Y KPH\n" + usual(parted=" ", fmt="%.9e").replace("e", "D"),
    refused="no line of two or more numbers",
)


def _lvm(name, x_columns, names, made, table=None, told="", **how):
    """LabVIEW's two heads, and rows."""
    more, parted, comma, units = ({"more": "", "parted": "\t", "comma": False, "units": "um\tum\tV"} | how).values()
    separator = "Comma" if parted == "," else "Tab"
    head = (
        f"LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\t{separator}\n"
        f"Decimal_Separator\t{',' if comma else '.'}\nMulti_Headings\tNo\nX_Columns\t{x_columns}\nTime_Pref\tRelative\n"
        f"Date\t2024/05/01\nTime\t10:00:00.123\n***End_of_Header***\t\n\t\nChannels\t3\t\t\t\nSamples\t8000\t8000\t8000\t\n{more}"
        f"Y_Unit_Label\t{units}\t\nX_Dimension\tTime\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.000250\t0.000250\t0.000250\t\n"
        f"***End_of_Header***\t\t\t\t\n"
    )
    if comma:
        head = head.replace("0.0E", "0,0E").replace("0.000250", "0,000250")

    def write(path):
        path.write_text(head.replace("\t", parted) + parted.join(names) + "\n" + made(), encoding="utf-8")

    dialect(name, "run.lvm", table or Table(unit=""), "", told)(write)


ONE = ("X_Value", "X", "Y", "KPH", "Comment")
_lvm("LVM, one column of X values", "One", ONE, lambda: usual(parted="\t"))
_lvm("LVM, X values asked for", "One", ONE, lambda: usual(parted="\t"), table=Table(more=by(time="X_Value"), unit=""))
_lvm("LVM, decimal commas", "One", ONE, lambda: usual(parted="\t", comma=True), comma=True)
_lvm("LVM, commas", "One", ONE, lambda: usual(parted=","), parted=",")
_lvm(
    "LVM, no X values",
    "No",
    ONE,
    lambda: "\t" + rows(list(signals().values()), parted="\t").rstrip("\n").replace("\n", "\n\t") + "\n",
)
_lvm(
    "LVM, X values for each channel",
    "Multi",
    ("X_Value", "X", "X_Value", "Y", "X_Value", "KPH", "Comment"),
    lambda: rows([c for s in signals().values() for c in (TIME, s)], parted="\t"),
)
_lvm("LVM, a comment in its first row", "One", ONE, lambda: usual(parted="\t").replace("\n", "\tbegins\n", 1))
_lvm(
    "LVM, times of day",
    "One",
    ONE,
    lambda: usual(parted="\t"),
    more="Time\t10:00:00.1\t10:00:00.2\t10:00:00.3\t\n",
    told="times of day",
)
_lvm("LVM, no units", "One", ONE, lambda: usual(parted="\t"), table=Table(), units="\t\t")


def _two_segments(path):
    one = "***End_of_Header***\nX_Value\tX\tY\tKPH\n" + usual(parted="\t")
    path.write_text("LabVIEW Measurement\nSeparator\tTab\n" + one * 3, encoding="utf-8")


dialect("LVM of several segments", "run.lvm", Table(unit=""), "several segments")(_two_segments)

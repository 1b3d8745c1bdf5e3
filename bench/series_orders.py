"""Which order of the Taylor series is fastest: processor time at equal error, in ms, least of 5 interleaved runs.

    python bench/series_orders.py [--problems P1 P1c P2 gyro] [--write]

Order 6 is told by as many numbers as the pair has stages, and cannot be asked for; from 16 on the controller does not
grow the step from the first one, which is far too short for them.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from peers import own
from problems import problem
from reference import solution
from rsc.kernel.tableau import METHODS

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
from pages import RESULTS, write_page

ORDERS = (7, 8, 9, 11, 12)
TOLERANCES = tuple(10.0**-i for i in range(2, 13))
ERRORS = (1e-3, 1e-6, 1e-9)
REPEATS = 5


def times_at_errors(name):
    """{order: ms at each of ERRORS}, between the points measured; NaN where no point is as exact."""
    case, exact = problem(name), solution(problem(name))
    runs = {order: own.Rsc(case, f"series {order}") for order in ORDERS}
    spent = np.full((len(ORDERS), len(TOLERANCES)), np.inf)
    errors = np.full_like(spent, np.nan)
    for _ in range(REPEATS):
        for i, run in enumerate(runs.values()):
            for j, tol in enumerate(TOLERANCES):
                outcome = run(tol)
                spent[i, j] = min(spent[i, j], outcome.seconds)
                if outcome.motion is not None:
                    errors[i, j] = abs(outcome.motion - exact.motion).max() / case.matrices.gap
    return {order: _at(ERRORS, errors[i], 1e3 * spent[i]) for i, order in enumerate(ORDERS)}


def _at(wanted, errors, spent):
    known = np.isfinite(errors)
    x, y = np.log(errors[known][::-1]), np.log(spent[known][::-1])
    order = np.argsort(x)
    return [float(np.exp(np.interp(np.log(w), x[order], y[order], left=np.nan))) for w in wanted]


def main():
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--problems", nargs="+", default=["P1", "P1c", "P2", "gyro"])
    parser.add_argument("--write", action="store_true", help="keep the table in bench/results")
    options = parser.parse_args()
    METHODS.update({f"series {order}": (0.0,) * order for order in ORDERS})
    heads = ["ms at error (gaps)", *(f"order {order}" for order in ORDERS)]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for name in options.problems:
        found = times_at_errors(name)
        for i, error in enumerate(ERRORS):
            lines.append(f"| {name} {error:.0e} | " + " | ".join(f"{found[order][i]:.1f}" for order in ORDERS) + " |")
    text = "\n".join(lines)
    print(text)
    if options.write:
        write_page(RESULTS / "series_orders.md", "Orders of the Taylor series", "python bench/series_orders.py --write", text)


if __name__ == "__main__":
    main()

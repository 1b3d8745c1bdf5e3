"""rsc's kernel, the naive yardstick and the C yardstick."""

import ctypes
import dataclasses
import time

import numpy as np

import c_code
from naive_kernel import naive_run
from peers.common import Absent, Outcome, refuse_driven
from problems import RATE, displacements
from rsc.kernel import model as kernel
from rsc.kernel.march import march
from rsc.kernel.tableau import METHODS
from rsc.simulation.pack import pack
from rsc.simulation.run import new_work
from rsc.simulation.stretches import room_for
from rsc.simulation.tolerances import first_step
from rsc.study.run.start import initial_state
from rsc.system.assemble import assemble

RSC_METHODS = tuple(METHODS)
CHUNK_STEPS = 20_000
CAUSES = {
    kernel.DIVERGED: "B",
    kernel.STEP_COLLAPSED: "C",
    kernel.NON_FINITE: "N",
    kernel.TOO_MANY_STEPS: "T",
    kernel.RUNNING: "T",
    kernel.TOO_STIFF: "T",
}


class Rsc:
    """The kernel on a problem: everything but the marching is done before the clock starts."""

    def __init__(self, problem, method="rk45"):
        self.problem, self.system, self.method = problem, assemble(problem.scene), method
        self.start = initial_state(problem.scene, self.system)

    def packed(self, tol):
        """The kernel's model at a tolerance."""
        solver = dataclasses.replace(self.problem.scene.solver, rtol=tol, method=self.method, max_steps=10**9)
        return pack(self.system, solver, RATE)

    def prepared(self, tol):
        """(Packed, Work, room for the output) of a run that has not begun."""
        packed = self.packed(tol)
        work = new_work(packed, self.start)
        return packed, work, np.zeros((self.problem.times.size + 8, work.x.size + 3 * len(self.system.contacts)))

    def march(self, prepared, limit=1e9):
        """(code, processor seconds) of a prepared run to its end."""
        packed, work, out = prepared
        begun = time.process_time()
        filled, code, facts = 0, kernel.RUNNING, room_for(packed.model)
        while code == kernel.RUNNING and time.process_time() - begun < limit:
            code, rows = march(packed.model, work, out[filled:], facts, packed.width, METHODS[self.method], CHUNK_STEPS)
            filled += rows
        return code, time.process_time() - begun

    def __call__(self, tol, limit=1e9):
        packed, work, out = prepared = self.prepared(tol)
        code, spent = self.march(prepared, limit)
        calls = int(work.count[kernel.RHS_CALLS])
        self.counts = {"steps": int(work.count[kernel.STEPS]), "rejected": int(work.count[kernel.REJECTED])}
        if code != kernel.FINISHED:
            return Outcome(spent, None, calls, CAUSES[code])
        return Outcome(spent, np.hstack(packed.physical(out[: self.problem.times.size, : work.x.size])), calls)


class Naive:
    """The yardstick on a problem."""

    def __init__(self, problem):
        self.problem = problem

    def __call__(self, tol, limit=1e9):
        begun = time.process_time()
        rows, accepted, rejected = naive_run(self.problem, tol, RATE)
        return Outcome(time.process_time() - begun, displacements(rows, self.problem), 6 * (accepted + rejected) + 1)


class PlainC:
    """c/dp5.c: the algorithm of rsc's Dormand-Prince core in C, on the same modal model."""

    def __init__(self, problem, ledger=True):
        refuse_driven(problem)
        self.problem, self.rsc = problem, Rsc(problem)
        model = self.rsc.packed(1e-3).model
        self.n = model.stiffness.size // 2
        flags = [f"-DN={self.n}"] + ["-DLEDGER"] * ledger
        flags += ["-DFULL"] * (len(model.damping_columns) > 0) + ["-DGYRO"] * (len(model.gyroscopic_columns) > 0)
        try:
            self.library = c_code.library("dp5", *flags)
        except c_code.NoCompiler as problem:
            raise Absent(str(problem)) from problem

    def __call__(self, tol, limit=1e9):
        packed = self.rsc.packed(tol)
        m, duration, width = packed.model, self.problem.duration, 2 * self.n
        work = new_work(packed, self.rsc.start)
        contact = m.contacts[0]
        rows = contact.contact_row, contact.force_row
        vectors = np.array([m.stiffness, m.damping, *rows, m.unbalance, m.euler, m.load, m.scale_x, m.scale_v])
        columns = np.zeros((2, self.n, width))
        for place, matrix in zip(columns, (m.damping_columns, m.gyroscopic_columns), strict=True):
            if len(matrix):
                place[:] = matrix
        rate = (m.corner_speed[1] - m.corner_speed[0]) / duration
        on = contact.surfaces
        law = contact.gap, on.friction, on.spring.k, on.damping
        numbers = [*law, m.switch_tol, m.rtol, m.h_max, m.divergence, RATE, duration, m.corner_speed[0]]
        numbers = np.array([*numbers, rate, first_step(packed)])
        state, out = np.concatenate([work.x, work.v]), np.zeros((self.problem.times.size + 8, width + 3))
        counts, energies = np.zeros(4, dtype=ctypes.c_long), np.zeros(2 + 2 * width)
        arguments = [c_code.pointer(part) for part in (vectors, columns, numbers, state, out, counts, energies)]
        begun = time.process_time()
        code = self.library.dp5(*arguments)
        spent = time.process_time() - begun
        self.counts = dict(zip(("steps", "rejected", "attempts", "switches"), counts.tolist(), strict=True))
        calls = 6 * self.counts["attempts"] + self.counts["switches"]
        if code != kernel.FINISHED:
            return Outcome(spent, None, calls, CAUSES[code])
        return Outcome(spent, np.hstack(packed.physical(out[: self.problem.times.size, :-3])), calls)

"""Exudyn, a multibody program in C++: its Runge-Kutta method of order 7 with fixed steps, forces in its symbolic form.

Masses, springs and dampers are matrices of one of its bodies; unbalance, gyroscopic terms and contact are functions that it
records as expressions and evaluates without Python. Its methods with a step of their own (DOPRI5) write no output between their
steps, so a fixed step that meets every output time takes part. The argument is the number of steps between two of these. A vector
of more than seven expressions ends the process (Exudyn 1.13.6), so the gyroscopic terms of ROSS cannot be given to it.
"""

import time

import numpy as np
from scipy.linalg import block_diag

from peers.common import Absent, Outcome, imported, refuse_driven
from problems import RATE

STAGES = 9
TINY = 1e-300  # m^2: no division by zero in the centre
LONGEST = 7  # entries of a vector of expressions
TRIAL = 400  # output times of a short run that gives the time of a step


def _both_planes(rotor, stator):
    """The matrix of a body whose nodes are the coordinates of rotor and stator, y and z in each."""
    return np.kron(block_diag(rotor, stator), np.eye(2))


def _contact(es, m, x, v):
    """Forces on the rotor's and the stator's node, expressions of their displacements and velocities (y, z, y, z)."""
    if m.stiffness_s.size:
        x, v = (x[0] - x[2], x[1] - x[3]), (v[0] - v[2], v[1] - v[3])
    distance = es.sqrt(x[0] * x[0] + x[1] * x[1] + TINY)
    closing = (x[0] * v[0] + x[1] * v[1]) / distance
    force = es.max(0.0, m.k_c * (distance - m.gap) - m.b_c * es.max(0.0, -closing))
    pushed = force * (x[0] - m.friction * x[1]) / distance, force * (x[1] + m.friction * x[0]) / distance
    forces = [-m.per_mass_r * each for each in pushed]
    return forces + [m.per_mass_s * each for each in pushed] if m.stiffness_s.size else forces


def _unbalance(es, m, i, t):
    """Forces on node i of the rotor."""
    phi, omega = m.omega * t + 0.5 * m.omega_dot * t * t, m.omega + m.omega_dot * t
    c, s, square, euler = es.cos(phi), es.sin(phi), float(m.unbalance[i]) * omega * omega, float(m.euler[i]) * m.omega_dot
    return [square * c + euler * s, square * s - euler * c]


def _gyroscopic(m, t, v):
    """Forces on all nodes of the rotor."""
    omega, forces = m.omega + m.omega_dot * t, []
    for row in m.gyroscopic_r:
        for other, sign in ((1, -1.0), (0, 1.0)):
            forces.append(sum((sign * float(g) * omega * v[2 * j + other] for j, g in enumerate(row)), 0.0 * t))
    return forces


class Exudyn:
    """A run that would go over the limit, by the time of a step in a short run, is not begun."""

    def __init__(self, problem):
        exudyn, tools = imported("exudyn"), imported("exudyn.advancedUtilities")
        refuse_driven(problem)
        if problem.matrices.gyroscopic_r.any() and 2 * problem.matrices.gyroscopic_r.shape[0] > LONGEST:
            raise Absent("Exudyn ends the process at gyroscopic terms of so many coordinates")
        self.exudyn, self.symbolic, self.problem = exudyn, tools.CreateSymbolicUserFunction, problem
        outputs = min(TRIAL, problem.times.size - 1)
        self.per_step = self._run(outputs, 1)[0] / outputs

    def _system(self):
        """(system, its sensors, the functions, which must live as long) at the start of the problem."""
        m, exu = self.problem.matrices, self.exudyn
        es, n, k = exu.symbolic, m.stiffness_r.shape[0], m.stiffness_s.shape[0]
        system = exu.SystemContainer().AddSystem()
        nodes = [system.AddNode({"nodeType": "GenericODE2", **begin}) for begin in self._coordinates()]
        damping, stiffness = _both_planes(m.damping_r, m.damping_s), _both_planes(m.stiffness_r, m.stiffness_s)
        whole = {"massMatrix": np.eye(2 * (n + k)), "stiffnessMatrix": stiffness, "dampingMatrix": damping}
        system.AddObject({"objectType": "GenericODE2", "nodeNumbers": nodes, **whole})
        functions = []

        def add(on, forces):
            size = 2 * len(on)

            def recorded(mbs, t, item, x, v):
                for values in (x, v):  # they come without their size
                    values.SetVector([0.0] * size)
                return es.Vector(forces(t, x, v))

            body = {"objectType": "GenericODE2", "nodeNumbers": on, "massMatrix": np.zeros((size, size))}
            number = system.AddObject(body)
            functions.append(self.symbolic(system, recorded, "forceUserFunction", number))
            system.SetObjectParameter(number, "forceUserFunction", functions[-1])

        add([nodes[m.i_r], nodes[n + m.i_s]] if k else [nodes[m.i_r]], lambda t, x, v: _contact(es, m, x, v))
        for i in np.flatnonzero(m.unbalance):
            add([nodes[i]], lambda t, x, v, i=i: _unbalance(es, m, i, t))
        if m.gyroscopic_r.any():
            add(nodes[:n], lambda t, x, v: _gyroscopic(m, t, v))
        written = {"outputVariableType": exu.OutputVariableType.Coordinates, "storeInternal": True, "writeToFile": False}
        sensors = [system.AddSensor({"sensorType": "Node", "nodeNumber": node, **written}) for node in nodes]
        system.Assemble()
        return system, sensors, functions

    def _coordinates(self):
        """What each node begins with."""
        n, start = self.problem.matrices.stiffness_r.shape[0], self.problem.start
        for values, velocities in zip(*(self._pairs(part, n) for part in np.split(start, 2)), strict=True):
            begin = {"initialCoordinates": values, "initialCoordinates_t": velocities}
            yield {"numberOfODE2Coordinates": 2, "referenceCoordinates": [0.0, 0.0], **begin}

    @staticmethod
    def _pairs(part, n):
        """(y, z) of each coordinate of half a state of the yardstick."""
        rotor, stator = part[: 2 * n].reshape(2, -1), part[2 * n :].reshape(2, -1)
        return np.hstack([rotor, stator]).T.tolist()

    def _run(self, outputs, substeps):
        """(processor seconds, complex displacements (samples, N + M), as many samples as were reached)."""
        system, sensors, _functions = self._system()
        settings = self.exudyn.SimulationSettings()
        steps, solution = settings.timeIntegration, settings.solution
        steps.endTime, steps.numberOfSteps = outputs / RATE, outputs * substeps
        steps.automaticStepSize = False
        steps.explicit.computeEndOfStepAccelerations = False
        solution.file.write, solution.sensors.writePeriod = False, 1.0 / RATE
        begun = time.process_time()
        system.SolveDynamic(settings, solverType=self.exudyn.DynamicSolverType.RK67)
        spent = time.process_time() - begun
        rows = [system.GetSensorStoredData(sensor) for sensor in sensors]
        return spent, np.column_stack([row[:, 1] + 1j * row[:, 2] for row in rows])

    def __call__(self, substeps, limit=1e9):
        outputs = self.problem.times.size - 1
        calls = STAGES * substeps * outputs
        if self.per_step * substeps * outputs > limit:
            return Outcome(float("nan"), None, calls, "T")
        seconds, motion = self._run(outputs, substeps)
        return Outcome(seconds, motion, calls) if motion.shape[0] == outputs + 1 else Outcome(seconds, None, calls, "C")

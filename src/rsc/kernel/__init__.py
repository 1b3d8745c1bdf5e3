"""The compiled kernel: adaptive Runge-Kutta pairs for rotor, stator and pseudolinear contact. SI and rad/s unless said.

What is integrated, for n = N + M complex coordinates x (modal, scaled to metres by rsc.simulation.pack), (2), (3) of physics.md:

    x'' = -K x - C x' + i Omega G x' + (Omega^2 - i Omega') U e^{i phi} - i Omega' W e^{i phi} + f0 - P F_C
    d   = Phi x + ecc_ring e^{i phi}                            contact deflection (4); penetration p = |d| - gap = -delta
    F_N = max(0, k_C p + b_C min(p', 0)) while p > 0, else 0    law (10), (11): damper only while separating, no tension
    F_C = (1 + i mu sigma) F_N d/|d|                            sigma = 1, or Coulomb with v_rel = Omega d_R/2 + Im(d' conj d)/|d|

K is diagonal (real modes of rotor and stator apart); C is a diagonal plus, only where needed, a full matrix; i Omega G acts
only where the rotor has gyroscopics. The contact law is smooth inside each of its states (open, closing, opening, clipped;
friction forward, creeping, backward); a step does not cross from one into the next: its end is put on the switch (switches.py).

Files: simd/ the decorators (jit.py), packed vectors (vec.py) and how they lie in registers (registers.py); model.py the data,
clock.py and turn.py time and rotation, contact.py the force law, rhs.py the accelerations, tableau.py the methods, step.py one
step, dense.py the motion inside it, control.py its length, switches.py where it must end, tally.py what is added up,
flight.py exact motion between contacts, march.py many steps with statuses.
"""

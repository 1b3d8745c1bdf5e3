"""The compiled kernel: adaptive Runge-Kutta pairs for rotor, stator and pseudolinear contact. SI units and rad/s unless stated.

What is integrated, for n = N + M complex coordinates x (modal, scaled to metres by rsc.simulation.pack), (2), (3) of physics.md:

    x'' = -K x - C x' + i Omega G x' + (Omega^2 - i Omega') U e^{i phi} - i Omega' W e^{i phi} + f0 - P F_C
    d   = Phi x + ecc_ring e^{i phi}                            contact deflection (4); penetration p = |d| - gap = -delta
    F_N = max(0, k_C p + b_C min(p', 0)) while p > 0, else 0    law (10), (11): damper only while separating, no tension
    F_C = (1 + i mu sigma) F_N d/|d|                            sigma = 1, or Coulomb with v_rel = Omega d_R/2 + Im(d' conj d)/|d|

K is diagonal (real modes of rotor and stator separately); C is a diagonal plus, only where needed, a full matrix; i Omega G is
present only if the rotor has gyroscopics. The contact law is smooth inside each of its states (open, closing, opening, clipped;
friction forward, creeping, backward); no step crosses from one into the next: it ends on the switch (switches.py).

Files: simd/ decorators (jit.py), packed vectors (vec.py) and their registers (registers.py); model.py data structures, clock.py
and turn.py time and rotation, contact.py force law, contact_forces.py what contacts push with, rhs.py accelerations, tableau.py
and series.py methods, step.py one step, dense.py interpolation inside it, control.py its length, switches.py end of a step on a
switch, tally.py and facts.py sums over the run, flight.py exact motion between contacts, march.py the loop over steps and its
status.
"""

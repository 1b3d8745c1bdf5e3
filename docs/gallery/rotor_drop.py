"""A rotor that falls into its auxiliary bearings: whether it whirls is decided by friction and by the bearings' inner races.

The magnetic bearings fail at 200 Hz, with the heavy spot at 24 angles. Where the races do not turn, friction drives the rotor
into the predicted whirl of both planes, with sixty times its weight; races that turn spin up, and it comes to lie in them.
"""

import matplotlib.pyplot as plt
import numpy as np

import rsc

BEARING = """
[[contact]]
name = "{name}"
rotor_coordinate = {number}
stator_coordinate = {number}
gap = "0.25 mm"
friction = 0.3
stiffness = "100 kN/mm"
damping = 2000
diameter = "50 mm"
slip_velocity = 0.02
race_inertia = 2e-4
race_drag = 2e-5
"""
DROP = rsc.Scene.from_toml("""
[rotor]                      # 20 kg, rigid: deflections of the planes 0.25 m before and 0.22 m behind its centre
model = "matrices"
mass = [[8.0036, 1.3581], [1.3581, 9.2802]]
gyroscopic = [[0.22635, -0.22635], [-0.22635, 0.22635]]
stiffness = [[0, 0], [0, 0]]
damping = [[0, 0], [0, 0]]
eccentricity = ["2 um", "2 um"]
tilt_coordinates = []
gravity = 9.81
[stator]                     # housings
model = "matrices"
mass = [[1.2, 0], [0, 1.2]]
stiffness = [[2e7, 0], [0, 2e7]]
damping = [[3e3, 0], [0, 3e3]]
[drive]
speed = "200 Hz"
duration = "1 s"
[start]
centre = true
""" + BEARING.format(name="front", number=0) + BEARING.format(name="rear", number=1))  # fmt: skip
FRICTION, ANGLES = np.array([0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45]), np.arange(0.0, 360.0, 15.0)
FIXED, TURNING = 1e6, 2e-4  # kg m2, of races that nothing turns, and of real ones


def drops(friction, inertia):
    """(share in % of the drops that end in a backward whirl, largest force of all in kN)."""
    changes = {"friction": friction, "race_inertia": inertia}.items()
    scene = DROP.with_values({f"contact.{end}.{key}": value for end in ("front", "rear") for key, value in changes})
    runs = rsc.simulate_many([scene.with_values({"rotor.eccentricity": [[2e-6, angle]] * 2}) for angle in ANGLES])
    ends = [run.stretches(end) for run in runs for end in ("front", "rear")]
    return 100.0 * np.mean([end.tail(0.2).turns < -10.0 for end in ends]), max(end.whole().force_max for end in ends) / 1e3


figure, panels = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
for inertia, label in ((FIXED, "races that do not turn"), (TURNING, "races that spin up")):
    told = np.array([drops(friction, inertia) for friction in FRICTION]).T
    print(f"{label}: at a friction of 0.3 {told[0, 4]:.0f} % of the drops end in a whirl, with up to {told[1, 4]:.1f} kN")
    for panel, values, axis in zip(panels, told, ("drops that end in a whirl in %", "largest normal force in kN"), strict=True):
        panel.plot(FRICTION, values, "o-", label=label)
        panel.set(ylabel=axis, ylim=(0.0, None), xlabel="coefficient of friction")
panels[0].legend(title=f"200 Hz, {len(ANGLES)} angles of release")
figure.savefig("rotor_drop.png", dpi=100)
whirl = next(one for one in rsc.predict(DROP) if len(one.pressed) == 2 and one.growth_rate < 0.0)
print(f"predicted: {whirl.frequency:.1f} Hz, {sum(own.normal_force for own in whirl.contacts.values()) / 1e3:.1f} kN in both")

"""Rotor drop on auxiliary bearings: friction and the inner races decide whether the rotor whirls.

The magnetic bearings fail at 200 Hz, with the heavy spot at 18 angles. Where the races do not turn, friction drives the rotor
into the predicted whirl of both planes, with sixty times its weight, and a larger unbalance adds little; races that turn spin
up, and it comes to lie in them.
"""

import matplotlib.pyplot as plt

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
ANGLE = "rotor.eccentricity.angle"
VARIED = {  # name -> values, in words, unit
    "contact.*.friction": ("0.1:0.4:7", "coefficient of friction", 1.0),
    "rotor.eccentricity.amount": (["1 um", "2 um", "5 um", "10 um", "20 um"], "eccentricity in um", 1e-6),
}
RACES = {"races that do not turn": 1e6, "races that spin up": 2e-4}  # inertia in kg m2

figure, panels = plt.subplots(2, 2, figsize=(9, 7), layout="constrained", sharey="row", sharex="col")
for label, inertia in RACES.items():
    for (name, (values, words, unit)), (top, bottom) in zip(VARIED.items(), panels.T, strict=True):
        data = rsc.sweep(DROP.with_values({"contact.*.race_inertia": inertia}), {name: values, ANGLE: "0:340:18"}, "run")
        share = 100.0 * data.motion.str.contains("backward whirl").mean(ANGLE)
        force = data.largest_force.max(ANGLE) / 1e3
        top.plot(data[name] / unit, share, "o-", label=label)
        bottom.plot(data[name] / unit, force, "o-")
        bottom.set(xlabel=words, ylim=(0.0, None))
        print(f"{label}, {words} {data[name][0] / unit:g} to {data[name][-1] / unit:g}:", end=" ")
        print(f"{share.min():.0f} to {share.max():.0f} % of the drops end in a whirl, with up to {force.max():.1f} kN")
panels[0, 0].set(ylabel="drops that end in a whirl in %")
panels[1, 0].set(ylabel="largest normal force in kN")
panels[0, 0].legend(title="200 Hz, 18 angles of release")
figure.savefig("rotor_drop.png", dpi=100)
whirl = next(one for one in rsc.predict(DROP) if len(one.pressed) == 2 and one.growth_rate < 0.0)
print(f"predicted: {whirl.frequency:.1f} Hz, {sum(own.normal_force for own in whirl.contacts.values()) / 1e3:.1f} kN in both")

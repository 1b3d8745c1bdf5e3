"""A pump trips during a rub: it stops within four seconds; without contact it coasts down for a minute.

The motor keeps the whirl that an impact starts, at a little more slip. Once it has tripped, friction at the seal ring brakes six
times as hard as the water at full speed, and more below. A prescribed coast-down of a minute would feed the whirl for a minute.
"""

import rsc
from rsc.show.words.held import outcomes_text

PUMP = rsc.Scene.from_toml("""
title = "Pump that trips while it rubs"

[rotor]                      # impeller and shaft
model = "laval"
mass = "12 kg"
frequency = "2600 rpm"
damping_ratio = 0.02
eccentricity = "5 um"

[stator]                     # seal ring
model = "laval"
mass = "3 kg"
frequency = "160 Hz"
damping_ratio = 0.1

[contact]
gap = "0.25 mm"
friction = 0.2
stiffness = "50 kN/mm"
damping_ratio = 0.05
diameter = "80 mm"

[drive]
inertia = 0.05               # kg m^2, pump, coupling and motor
torque = [[0, 20], [42, 30], [50, 0]]          # Hz, N m: motor less pump
speed = "50 Hz"
duration = "6 s"
trip = "1 s"
coast = [[0, -0.1], [25, -0.3], [50, -0.9]]    # what the water takes

[start]
running = true
impulse = ["5 N s", 0]
""")

for motion in rsc.motions(PUMP, starts=16).motions:
    print(f"{motion.motion}: {motion.torque:.2f} N m, {outcomes_text(motion.held)}")
report = rsc.check(PUMP)
run = report.result
print(f"with the motor: {run.speed[run.time < PUMP.drive.trip][-1]:.2f} Hz at the trip")
slow, end = (time - PUMP.drive.trip for time in (run.time[run.speed > 1.0][-1], run.summary.end_time))
print(f"after the trip: below 1 Hz in {slow:.1f} s, {run.status} in {end:.1f} s; {-run.ledger.friction_in:.0f} J of heat in all")
report.save_html("coast_down.html")
report.plot("campbell").figure.savefig("coast_down.png")

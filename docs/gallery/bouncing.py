"""Bouncing backward whirl, which linear stability does not show.

With a friction of 0.3 no whirl of this pump that slides is stable: the growth rates say so. But the motion does not end where the
rotor leaves the ring: it comes back, bounces, and stays in a backward whirl of its own, with peaks of four kilonewton.
"""

import rsc

PUMP = rsc.Scene.from_toml("""
title = "Pump rotor, friction 0.3, after an impact"

[rotor]
model = "laval"
mass = "12 kg"
frequency = "2600 rpm"
damping_ratio = 0.02
eccentricity = "0.02 mm"

[stator]
model = "laval"
mass = "3 kg"
frequency = "160 Hz"
damping_ratio = 0.1

[contact]
gap = "0.25 mm"
friction = 0.3
stiffness = "50 kN/mm"
damping_ratio = 0.05
diameter = "80 mm"

[drive]
speed = "3000 rpm"
duration = "6 s"

[start]
running = true
impulse = ["3 N s", 0]

[output]
rate = 4000.0
""")

speed = PUMP.drive.speed[0]
for whirl in rsc.predict(PUMP, speed):
    if whirl.rotor_amplitude > PUMP.contact.gap:
        print(f"predicted: {whirl.frequency:.1f} Hz, {whirl.normal_force:.0f} N, growth {whirl.growth_rate:+.0f} 1/s")

report = rsc.check(PUMP)
last = report.stretches.tail(2.0)
told = f"{last.turning:.1f} Hz, peaks of {last.force_max:.0f} N, in contact for {last.share:.0%} of the time"
print(f"simulated: {report.features.kind[-1]}, {told}")
report.save_html("bouncing.html")
report.plot("orbit").figure.savefig("bouncing.png")

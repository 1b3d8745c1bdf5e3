"""Overhung fan: no sliding whirl is stable, yet impacts end in the worst motion, rolling.

The wheel on the end of its shaft splits its natural frequency in two by its gyroscopic moments. A list of predicted whirls that
slide would call this fan safe; `rsc.motions` simulates from everything predicted and after impacts, and finds rolling.
"""

import rsc

FAN = rsc.Scene.from_toml("""
title = "Overhung fan"

[rotor]                      # a wheel on the end of a shaft of 90 mm, 0.6 m behind its last bearing
model = "disk"
mass = "180 kg"
diametral_inertia = 18.0
polar_inertia = 32.0
stiffness = [["37.6e6 N/m", "-11.27e6 N/rad"], ["-11.27e6 N/rad", "4.509e6 N*m/rad"]]
damping_ratio = 0.02
eccentricity = "40 um"
gravity = 9.81

[stator]                     # the inlet cone
model = "laval"
mass = "12 kg"
frequency = "45 Hz"
damping_ratio = 0.05

[contact]
gap = "2 mm"
friction = 0.3
stiffness = "5 kN/mm"
damping_ratio = 0.05
diameter = "800 mm"

[drive]
speed = "1480 rpm"
duration = "10 s"
""")

speed = FAN.drive.speed[0]
print("free modes:", ", ".join(f"{mode.frequency:.1f} Hz" for mode in rsc.modes(FAN, speed).rotor))
for whirl in rsc.predict(FAN, speed):
    if whirl.rotor_amplitude > FAN.contact.gap:
        print(f"predicted: {whirl.frequency:.1f} Hz, {whirl.normal_force / 1e3:.1f} kN, growth {whirl.growth_rate:+.1f} 1/s")

listed = rsc.motions(FAN, starts=16)
for motion in listed.motions:
    size = f"{motion.force_max / 1e3:.0f} kN and {motion.power / 1e3:.0f} kW"
    print(f"lasts: {motion.motion}, up to {size}, {motion.share:.0%} of impacts")
print(f"with 95 % confidence any one other motion is started by fewer than {listed.excluded:.0%} of impacts")
listed.plot().figure.savefig("overhung_fan.png")

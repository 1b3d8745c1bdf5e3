"""A scene of a shaft by its stations as text, whose tables can be exchanged."""

SECTIONS = """[
  {length = "120 mm", diameter = "40 mm"},
  {name = "seat", length = "300 mm", diameter = "60 mm", bore = "20 mm"},
  {length = "80 mm", diameter = ["60 mm", "40 mm"]},
]"""
DISKS = """[
  {name = "impeller", at = "270 mm", mass = "12 kg", polar_inertia = 0.12, diametral_inertia = 0.07},
  {at = "400 mm", diameter = "200 mm", width = "30 mm"},
]"""
BEARINGS = """[
  {name = "drive end", at = "20 mm", stiffness = "5e7 N/m", damping = "1e4 N s/m"},
  {at = "480 mm", stiffness = "5e7 N/m", damping = "1e4 N s/m"},
]"""
SCENE = """
[rotor]
model = "shaft"
sections = {sections}
disks = {disks}
bearings = {bearings}
{rotor}
[contact]
at = {at}
gap = "0.2 mm"
friction = 0.15
stiffness = 1e8
damping_ratio = 0.05
{stator}
[drive]
speed = "3000 rpm"
duration = 0.1
[reduction]
band = [-100.0, 100.0]
{more}
"""
STATOR = """[stator]
model = "laval"
mass = 6.0
frequency = 120.0
damping_ratio = 0.05
"""


def text(sections=SECTIONS, disks=DISKS, bearings=BEARINGS, at='"330 mm"', **others):
    values = {"rotor": "", "stator": STATOR, "more": "", **others}
    return SCENE.format(sections=sections, disks=disks, bearings=bearings, at=at, **values)

"""Scenes of all terms in all combinations, as hypothesis strategies of dicts for `Scene.from_dict`."""

from hypothesis import strategies as st


def size(low, high):
    """Floats of any digits, 0 in the place of those too small for a scene."""
    return st.floats(low, high).map(lambda number: number if abs(number) > 1e-90 else 0.0)


def maybe(draw, **keys):
    """Some of some keys, drawn."""
    return {key: draw(value) for key, value in keys.items() if draw(st.booleans())}


def one_of(draw, **keys):
    """One of some keys, drawn."""
    key = draw(st.sampled_from(sorted(keys)))
    return {key: draw(keys[key])}


def several(value, n):
    """Lists of n values."""
    return st.lists(value, min_size=n, max_size=n)


POLAR = st.one_of(size(0.0, 1e-4), st.just("G 6.3"), st.tuples(size(1e-6, 1e-4), size(-400.0, 400.0)).map(list))
PAIR = st.tuples(size(-1e-5, 1e-5), size(-1e-5, 1e-5)).map(list)
FOUR = st.tuples(size(1e4, 1e5), size(-1e3, 1e3), size(-1e3, 1e3), size(1e4, 1e5)).map(list)
DAMPERS = several(size(0.0, 5.0), 4)


@st.composite
def supports_by_speed(draw, place):
    """Knots in the order of their speeds, with or without dampers."""
    speeds = sorted(draw(st.lists(size(-200.0, 200.0), min_size=2, max_size=5, unique=True)))
    dampers = draw(st.booleans())
    return [[place, [[speed, draw(FOUR), *([draw(DAMPERS)] if dampers else [])] for speed in speeds]]]


@st.composite
def bodies(draw, kind):
    """(table, number of coordinates, tilts) of a rotor or a stator."""
    models = ["laval", "chain", "matrices", "reduced", "shaft", *(["disk"] if kind == "rotor" else ["rigid"])]
    model = draw(st.sampled_from(models))
    if model in ("rigid", "shaft"):
        return draw(shafts(kind)) if model == "shaft" else {"model": model}, 0, ()
    if model == "reduced":
        return draw(reduced_bodies(kind))
    n = {"laval": 1, "disk": 2}.get(model) or draw(st.integers(1, 3))
    ratio = {"damping_ratio": size(0.0, 0.3)}
    table, tilts = {"model": model}, ()
    if model == "laval":
        table |= {"mass": draw(st.one_of(size(0.5, 20.0), st.sampled_from(["250 g", "30 lb"])))}
        table |= one_of(draw, frequency=st.one_of(size(10.0, 200.0), st.just("2600 RPM")), stiffness=size(1e4, 1e7))
        table |= one_of(draw, damping=size(0.0, 100.0), **ratio)
    elif model == "disk":
        table |= {"mass": 1.0, "diametral_inertia": draw(size(0.009, 0.012)), "polar_inertia": draw(size(0.0, 0.018)),
                  "stiffness": [[69408.0, -3160.6], [-3160.6, draw(size(1300.0, 1500.0))]], **maybe(draw, **ratio)}  # fmt: skip
        tilts = (1,)
    elif model == "chain":
        table |= {"masses": draw(several(size(0.5, 5.0), n)), "stiffnesses": draw(several(size(1e4, 1e6), n + 1))}
        table |= one_of(draw, dampings=several(size(0.0, 50.0), n + 1), rayleigh=several(size(0.0, 1e-3), 2), **ratio)
    else:
        diagonal = draw(several(size(1e4, 1e6), n))
        table |= {"mass": [[float(i == k) for k in range(n)] for i in range(n)],
                  "stiffness": [[diagonal[i] if i == k else 10.0 for k in range(n)] for i in range(n)],
                  **maybe(draw, skew_stiffness=several(several(st.just(7.5), n), n))}  # fmt: skip
        table |= one_of(draw, damping=st.just([[3.0 * (i == k) for k in range(n)] for i in range(n)]), **ratio)
    if draw(st.booleans()):
        table["supports"] = [[0, draw(FOUR), *([draw(DAMPERS)] if draw(st.booleans()) else [])]]
    if kind == "rotor":
        table |= draw(rotor_keys(model, n))
    return table, n, tilts


def symmetric(draw, n, diagonal, beside):
    """An n x n matrix, symmetric, of drawn numbers."""
    table = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for k in range(i + 1):
            table[i][k] = table[k][i] = draw(diagonal if i == k else beside)
    return table


@st.composite
def reduced_bodies(draw, kind):
    """(table, number of coordinates, those that are no displacements at a contact) of what a finite-element model becomes."""
    n = draw(st.integers(1, 3))
    touching = draw(st.integers(1, n)) if kind == "rotor" else n

    def matrix(order=n, low=0.0, high=5e3, beside=st.just(0.0)):  # noqa: B008
        return symmetric(draw, order, size(low, high), beside)

    def of_conjugate():
        return symmetric(draw, n, PAIR, PAIR)

    table = {"model": "reduced", "mass": draw(size(0.5, 20.0)), "stiffness": matrix(n, 1e5, 1e6, size(-1e4, 1e4)),
             "damping": matrix(n, 10.0, 1e3, size(-1.0, 1.0)), "coordinates_before": draw(st.integers(n, 10**6)),
             "origin": draw(st.text(min_size=1, max_size=20).filter(_is_unicode)),
             "tolerance": draw(size(1e-6, 1e-2)), "error": draw(size(0.0, 1e-2)),
             "band": [draw(size(-900.0, -1.0)), draw(size(1.0, 900.0))], "speeds": [-100.0, draw(size(100.0, 200.0))],
             "highest_before": draw(size(1e3, 1e6)), "highest_after": draw(size(1e2, 1e3))}  # fmt: skip
    if touching > 1:
        table["contact_masses"] = matrix(touching, 1.0, 20.0, size(-0.3, 0.3))
    drawn = {"skew_stiffness": matrix, "skew_damping": matrix, "anisotropic_stiffness": of_conjugate,
             "anisotropic_damping": of_conjugate, "directions_error": lambda: draw(size(0.0, 1.0)),
             "coefficients_at": lambda: draw(size(-90.0, 90.0))}  # fmt: skip
    observers = draw(st.integers(0, 2))
    table |= {"observers": [f"node {i}" for i in range(observers)], "observer_errors": draw(several(size(0.0, 1.0), observers)),
              "observer_rows": draw(several(several(size(-1.0, 1.0), n), observers))}  # fmt: skip
    if kind == "rotor":
        table |= {"unbalance": draw(several(PAIR, n)), "load": draw(several(PAIR, n))}
        drawn |= {"gyroscopic": matrix, "rotating_damping": matrix}
        if draw(st.booleans()):
            speeds = sorted(draw(st.lists(size(-100.0, 100.0), min_size=2, max_size=4, unique=True)))
            kinds = {"stiffness": matrix, "damping": matrix, "skew_stiffness": matrix, "anisotropic_stiffness": of_conjugate}
            chosen = draw(st.lists(st.sampled_from(sorted(kinds)), min_size=1, unique=True))
            table |= {"knot_speeds": speeds, **{f"{key}_knots": [kinds[key]() for _ in speeds] for key in chosen}}
    table |= {key: make() for key, make in drawn.items() if draw(st.booleans())}
    return table, n, tuple(range(touching, n))


@st.composite
def shafts(draw, kind):
    """A shaft by its stations, which is reduced when it is read."""
    place = st.one_of(size(0.05, 0.5), st.sampled_from(["100 mm", {"section": "seat", "left": 0.05}]))
    sections = [{"length": "120 mm", "diameter": draw(st.sampled_from(["40 mm", [0.04, 0.05]]))},
                {"name": "seat", "length": 0.3, "diameter": 0.06, **maybe(draw, bore=size(0.0, 0.04))},
                {"length": 0.13, "diameter": [0.06, 0.04], **maybe(draw, material=st.sampled_from(["titanium", "aluminium"]))}]
    disk = one_of(draw, mass=size(1.0, 20.0), diameter=size(0.1, 0.3))
    disk |= {"polar_inertia": 0.05, "diametral_inertia": 0.03} if "mass" in disk else {"width": 0.03}
    four = FOUR.map(lambda numbers: [1e3 * number for number in numbers])
    stiffness, damping = st.one_of(size(1e7, 1e8), four), size(0.0, 1e4)
    held = {at: {"stiffness": draw(stiffness), **maybe(draw, damping=damping)} for at in (0.02, 0.53)}
    bearings = [{"name": f"b{at}", "at": at, **own} for at, own in held.items()]
    table = {"model": "shaft", "sections": sections, "disks": [{"at": draw(place), **disk}], "bearings": bearings}
    table |= maybe(draw, elements=st.integers(1, 2), shear=st.booleans(), rayleigh=several(size(0.0, 1e-5), 2),
                   observers=st.just(["200 mm"]))  # fmt: skip
    if kind == "rotor":
        planes = st.lists(st.fixed_dictionaries({"at": place, "amount": size(0.0, 1e-3), "angle": size(0.0, 360.0)}), max_size=2)
        table |= maybe(draw, unbalance=planes, shaft_damping=size(0.0, 1e-5), gravity=size(0.0, 20.0))
    return table


@st.composite
def rotor_keys(draw, model, n):
    """What a rotor has besides."""
    listed = model in ("chain", "matrices")
    rotating = {"laval": size(0.0, 10.0), "chain": several(size(0.0, 10.0), n + 1)}
    keys = maybe(
        draw,
        eccentricity=several(POLAR, n) if listed else POLAR,
        supports_by_speed=supports_by_speed(0),
        **({"rotating_damping": rotating[model]} if model in rotating else {}),
        **({"angular_eccentricity": st.tuples(size(0.0, 1e-3), size(0.0, 360.0)).map(list)} if model == "disk" else {}),
    )
    if model == "laval" and "rotating_damping" not in keys:
        keys |= maybe(draw, rotating_damping_ratio=size(0.0, 0.1))
    return keys | one_of(draw, gravity=st.one_of(size(0.0, 20.0), st.just("1 g")), load=several(PAIR, n))


@st.composite
def contacts(draw, rotor, stator, driven):
    """One to three contacts: their places do not matter to a round trip."""
    made = []
    for i in range(draw(st.integers(1, 3))):
        table = {"friction": draw(size(0.0, 0.5)), "stiffness": draw(size(1e5, 1e8))}
        table |= one_of(draw, gap=st.one_of(size(1e-4, 1e-3), st.just("10 mil")), stator_diameter=size(0.0505, 0.052))
        table |= one_of(draw, damping=size(0.0, 100.0), damping_ratio=size(0.0, 1.0))
        if driven or "stator_diameter" in table or draw(st.booleans()):
            table |= {"diameter": 0.05, "slip_velocity": draw(size(1e-4, 1e-1))}
            if draw(st.booleans()):
                table |= {"race_inertia": draw(size(1e-5, 1e-3)), **maybe(draw, race_drag=size(0.0, 1e-3))}
        table |= maybe(draw, ring_eccentricity=st.tuples(size(0.0, 1e-5), size(0.0, 360.0)).map(list), offset=PAIR)
        table |= maybe(draw, yield_force=size(1.0, 1e6))
        table |= draw(_places(rotor, stator))
        made.append(table | {"name": f"place_{i}"})
    return made if len(made) > 1 else draw(st.sampled_from([made, made[0]]))


@st.composite
def _places(draw, rotor, stator):
    """Where a contact is: coordinates, or places along a shaft."""
    along = size(0.05, 0.5)
    if rotor[1]:
        places = {"rotor_coordinate": draw(st.sampled_from([k for k in range(rotor[1]) if k not in rotor[2]]))}
    else:
        places = {"at": draw(along)}
    if stator[1]:
        return places | {"stator_coordinate": draw(st.integers(0, stator[1] - 1))}
    return places | ({"stator_at": draw(along)} if stator[0]["model"] == "shaft" else {})


@st.composite
def drives(draw):
    """Each form of [drive]; (table, whether a torque drives it)."""
    speed, duration = size(-90.0, 90.0), draw(st.one_of(size(0.1, 5.0), st.just("250 ms")))
    form = draw(st.sampled_from(["constant", "linear", "schedule", "torque", "trip"]))
    if form in ("constant", "linear"):
        return {"speed": draw(speed if form == "constant" else several(speed, 2)), "duration": duration}, False
    if form == "schedule":
        times = sorted(draw(st.lists(size(0.01, 9.0), min_size=1, max_size=6, unique=True)))
        return {"schedule": [[time, draw(speed)] for time in [0.0, *times]]}, False
    speeds = sorted(draw(st.lists(size(1.0, 90.0), min_size=2, max_size=5, unique=True)))
    knots = several(size(0.1, 9.0), len(speeds)).map(lambda torques: [list(knot) for knot in zip(speeds, torques, strict=True)])
    table = {"speed": draw(size(0.0, 50.0)), "duration": 2.0, "inertia": draw(size(0.01, 1.0)), "torque": draw(knots)}
    return table | ({"trip": draw(size(0.1, 1.9)), **maybe(draw, coast=knots)} if form == "trip" else {}), True


@st.composite
def starts(draw, rotor, stator, count):
    """Each kind of start."""
    states = {"rotor": several(PAIR, rotor[1]), "rotor_velocity": several(PAIR, rotor[1])} if rotor[1] else {}
    states |= {"stator": several(PAIR, stator[1]), "stator_velocity": several(PAIR, stator[1])} if stator[1] else {}
    table = draw(st.sampled_from([{"rest": True}, {"centre": True}, {"running": True}, {"whirl": "backward"},
                                  {"whirl": -31.25}, maybe(draw, **states)]))  # fmt: skip
    if count == 1:
        table |= maybe(draw, impulse=PAIR)
    return {**table, "allow_penetration": True}


@st.composite
def scenes(draw):
    """Dicts of scenes."""
    rotor, stator, (drive, driven) = draw(bodies("rotor")), draw(bodies("stator")), draw(drives())
    touching = draw(contacts(rotor, stator, driven))
    scene = {"title": draw(st.text(max_size=30).filter(_is_unicode)), "rotor": rotor[0], "stator": stator[0], "contact": touching}
    scene["drive"] = drive
    scene["start"] = draw(starts(rotor, stator, len(touching) if isinstance(touching, list) else 1))
    scene["solver"] = maybe(draw, method=st.sampled_from(["rk45", "taylor8", "auto"]), rtol=size(1e-10, 1e-2),
                            max_steps=st.integers(1, 2**62), divergence=size(2.0, 1e9))  # fmt: skip
    scene["output"] = maybe(draw, rate=size(1e5, 1e6), velocities=st.booleans())
    if "shaft" in (rotor[0]["model"], stator[0]["model"]):
        scene["reduction"] = {"tolerance": 1e-2, "band": [-120.0, 120.0]}
    places = [k for k in range(rotor[1]) if k not in rotor[2]]
    scene["clearance"] = [{"name": f"seal_{i}", "gap": draw(size(1e-4, 1e-2)), **(
                              {"rotor_coordinate": draw(st.sampled_from(places))} if places else {"at": draw(size(0.05, 0.5))})}
                          for i in range(draw(st.integers(0, 3)))]  # fmt: skip
    if draw(st.booleans()):
        top = draw(size(10.0, 100.0))
        probe = {"probe": "seal_0"} if scene["clearance"] else {}
        scene["limits"] = {"maximum_continuous": top, **probe, **maybe(draw, minimum=size(1.0, top), trip=size(top, 200.0))}
    return scene


def _is_unicode(text):
    return not any("\ud800" <= c <= "\udfff" for c in text)

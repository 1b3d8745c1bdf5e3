"""`rsc explore`: what follows from moved values, and a server that answers nobody but its own page."""

import http.client
import json
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import rsc
from rsc.cli import main
from rsc.study.explore.live import Job, Live
from scenes import LAVAL, TWO, changed

SCENE = rsc.Scene.from_dict(changed(LAVAL, drive={"speed": 50.0, "duration": 0.4}) | {"start": {"running": True}})
POST = {"Content-Type": "application/json"}


@pytest.fixture(scope="module")
def page():
    with rsc.explore(SCENE) as running:
        yield running


def send(page, method, path, body=None, **headers):
    """(status, text, headers) of a request with exactly these headers."""
    host, port = page.host.split(":")
    connection = http.client.HTTPConnection(host, int(port), timeout=200)
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in ({"Host": page.host} | headers).items():
        if value is not None:
            connection.putheader(name, value)
    content = b"" if body is None else body
    if body is not None and "Content-Length" not in headers:
        connection.putheader("Content-Length", str(len(content)))
    connection.endheaders(content)
    answer = connection.getresponse()
    text = answer.read().decode("latin-1")
    connection.close()
    return answer.status, text, answer.headers


def ask(page, part, **asked):
    status, text, _ = send(page, "POST", f"/{page.token}/{part}", json.dumps(asked).encode(), **POST)
    assert status == 200, text
    return json.loads(text)


def test_the_page_has_its_scripts_and_a_policy(page):
    for name, part in (("", "<title>"), ("explore.js", "use strict")):
        status, text, headers = send(page, "GET", f"/{page.token}/{name}")
        assert status == 200 and part in text and "default-src 'none'" in headers["Content-Security-Policy"]
    assert send(page, "GET", f"/{page.token}/plotly.js")[0] == 200
    assert page.host.startswith("127.0.0.1:") and len(page.token) >= 32 and page.token in repr(page)


def test_moved_values_are_those_of_the_prediction(page):
    moved = {"speed": 45.0, "contact.friction": 0.15}
    answer = ask(page, "whirls", values=moved) | ask(page, "words", values=moved)
    whirls = rsc.predict(SCENE.with_values({"contact.friction": 0.15, "drive.speed": 45.0}), 45.0)
    assert answer["stable"] == sum(whirl.stable for whirl in whirls)
    assert f"{whirls[0].frequency:.4f}"[:6] in answer["words"]
    listed = [whirl.frequency for whirl in whirls if whirl.stable]
    assert all(f"sliding at {frequency:.4g} Hz" in answer["verdict"] for frequency in listed)
    assert answer["verdict"].count("ing at ") == answer["verdict"].count("rolling at") + len(listed)
    assert answer["verdict"].endswith("Severity: at least at risk.")
    dots = [t for t in answer["picture"]["data"] if t["mode"] == "markers"]
    assert {t["name"] for t in dots} <= {"predicted whirl, stable", "predicted whirl, unstable"} and dots


def test_what_lasts_is_told_with_rolling_and_the_limits_of_the_model():
    rig = Live(rsc.Scene.from_dict({**SCENE.to_dict(), "contact": {**SCENE.to_dict()["contact"], "diameter": 0.04}}))
    assert "rolling at -" in rig.words({})["verdict"]
    free = rig.words({"contact.friction": 0.001})["verdict"]
    assert "no backward whirl lasts" in free
    deep = rig.words({"contact.gap": 0.25 * SCENE.contacts[0].gap, "contact.friction": 0.3})["verdict"]
    assert "beyond the model" in deep


def test_the_short_run_and_the_map(page):
    run = ask(page, "run", values={"speed": 50.0})
    assert {"orbit", "spectrum", "words"} == set(run) and run["words"].startswith("finished")
    for axes in (("speed", "contact.friction"), ("contact.gap", "speed"), ("contact.gap", "contact.friction")):
        (heat,) = ask(page, "map", values={}, x=axes[0], y=axes[1])["picture"]["data"]
        assert np.shape(heat["z"]) == (len(heat["y"]), len(heat["x"])) == (15, 21)
        i, j = 7, 10
        place = dict(zip(axes, (heat["x"][j], heat["y"][i]), strict=True))
        speed = place.pop("speed", 50.0)
        place = {name: value / {"contact.gap": 1e3}.get(name, 1.0) for name, value in place.items()}  # shown in mm
        sizes = [w.rotor_amplitude for w in rsc.predict(SCENE.with_values(place) if place else SCENE, speed) if w.stable]
        factor = {"mm": 1e3, "um": 1e6}[heat["colorbar"]["title"]["text"]]
        assert heat["z"][i][j] == pytest.approx(factor * max(sizes, default=0.0), rel=1e-3)


def test_the_scene_that_is_saved_has_the_values_and_its_drive(page):
    text = ask(page, "toml", values={"speed": 45.0, "contact.friction": 0.15})["text"]
    saved = rsc.Scene.from_toml(text)
    assert saved.contact.friction == 0.15 and saved.drive.speed == SCENE.drive.speed


def test_the_list_is_made_in_the_background(page):
    assert ask(page, "list", values={})["state"] == "running"
    deadline = time.monotonic() + 120.0
    while (told := ask(page, "listed"))["state"] == "running":
        assert time.monotonic() < deadline
        time.sleep(0.2)
    assert told["state"] == "done" and told["ended"] > 0 and "motion" in told["words"]


BAD = [{"values": {"contact.frictions": 1.0}}, {"values": {"speed": "fast"}}, {"values": {"speed": 1e400}}, {"values": [1]},
       {"values": {"contact.friction": -3.0}}, {"values": {"contact.gap": True}}, {"values": {"__class__": 1.0}}]  # fmt: skip


@pytest.mark.parametrize("asked", BAD)
def test_values_that_cannot_be_are_refused_in_words(asked, page):
    answer = ask(page, "whirls", **asked)
    assert list(answer) == ["error"] and answer["error"] and "Traceback" not in answer["error"]
    assert ask(page, "map", values={}, x="speed", y="speed")["error"]


def test_requests_from_elsewhere_are_refused(page):
    good, post, token = f"/{page.token}/", POST, page.token
    for path in ("/", "/x", "/plotly.js", f"/{token}", f"/{token[:-1]}/", "/../../etc/passwd", "/" + "a" * 5000):
        assert send(page, "GET", path)[0] == 403, path
    for host in ("example.org", f"localhost.example.org:{page.host.split(':')[1]}", "127.0.0.1", None):
        assert send(page, "GET", good, Host=host)[0] == 403
    assert send(page, "GET", good, Origin="http://example.org")[0] == 403
    assert send(page, "POST", good + "toml", b"{}", Origin="null", **post)[0] == 403
    tricks = "../live.py", "%2e%2e/live.py", "live.py", "/etc/passwd", "..%2f..%2f__init__.py", "explore.html", "explore.js/"
    for path in tricks:
        assert send(page, "GET", good + path)[0] == 404, path
    for body, how in ((b"{", post), (b"[]", post), (b"{}", {"Content-Type": "text/plain"}), (b"[" * 90_000, post)):
        assert send(page, "POST", good + "whirls", body, **how)[0] == 400
    assert send(page, "POST", good + "whirls", b"{}", **post, **{"Content-Length": "999999999"})[0] == 400
    assert send(page, "POST", good + "whirls", b"{}", **post, **{"Content-Length": "-1"})[0] == 400
    assert send(page, "POST", good + "closed", b"{}", **post)[0] == 400
    assert send(page, "PUT", good)[0] == 501


@pytest.mark.parametrize("number", [500, pytest.param(10_000, marks=pytest.mark.nightly)])
def test_a_flood_and_silent_connections_leave_the_page_answering(page, number):
    address = ("127.0.0.1", int(page.host.split(":")[1]))
    silent = [socket.create_connection(address) for _ in range(50)]
    with ThreadPoolExecutor(8) as pool:
        refused = list(pool.map(lambda i: send(page, "GET", f"/{i}/x")[0], range(number)))
    assert set(refused) == {403}
    assert ask(page, "words", values={})["words"]
    for each in silent:
        each.close()


def test_a_port_in_use_is_refused(page, tmp_path, capsys):
    port = int(page.host.split(":")[1])
    with pytest.raises(rsc.SolverError, match=f"port {port}: cannot be used"):
        rsc.explore(SCENE, port)
    with pytest.raises(rsc.SolverError, match="cannot be used"):
        rsc.explore(SCENE, 99999)
    (tmp_path / "scene.toml").write_text(SCENE.to_toml())
    assert main(["explore", str(tmp_path / "scene.toml"), "--port", str(port)]) == 2
    assert "cannot be used" in capsys.readouterr().err


def test_what_is_not_live_at_several_contacts_is_said():
    live = Live(rsc.Scene.from_dict(TWO))
    assert live.whirls({"speed": 50.0}) == {"picture": None} and live.words({"speed": 50.0})["words"]
    with pytest.raises(rsc.SolverError, match="not live"):
        live.map({}, "speed", live.handles[1].name)


def test_a_start_that_is_no_more_is_told_and_the_rotor_runs():
    scene = rsc.Scene.from_dict(changed(LAVAL, drive={"speed": 50.0, "duration": 0.4}) | {"start": {"whirl": "backward"}})
    live = Live(scene)
    assert live.run({})["words"].startswith("finished")
    assert live.run({"contact.friction": 0.05})["words"].startswith("the whirl to start on is no more")


def test_a_slow_machine_is_shown_at_fewer_speeds(monkeypatch):
    live = Live(SCENE)
    monkeypatch.setattr("rsc.study.explore.live.AT_ONCE", 0.0)
    counts = []
    for _ in range(4):
        live.whirls({})
        counts.append(live._n_speeds)
    assert counts == [30, 15, 13, 13]


def test_another_list_ends_the_one_before(monkeypatch):
    live, job, ended = Live(SCENE), Job(), []

    def slow(values, note):
        for i in range(1000):
            note(i, 1000)
            time.sleep(0.01)
        ended.append(values)

    monkeypatch.setattr(live, "listed", slow)
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(job.run, live, {"speed": 1.0})
        time.sleep(0.1)
        told = job.told
        monkeypatch.setattr(live, "listed", lambda values, note: "done")
        job.run(live, {"speed": 2.0})
        first.result(timeout=5.0)
    assert told["state"] == "stopped" and job.told == {"state": "done", "ended": 0, "of": 0, "words": "done"} and not ended

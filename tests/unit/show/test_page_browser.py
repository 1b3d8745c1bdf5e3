"""report.html in headless Chromium: nothing on the console, every picture, a cursor that moves the orbit, paper."""

import re
from dataclasses import replace

import numpy as np
import pytest

import rsc
from browsers import chromium, needs_chromium
from reports import short_report
from rsc.show.page import write_page
from shaft_scenes import text

pytestmark = needs_chromium
HOSTILE = '</title></script><script>document.title="taken"</script><img src="https://example.org/x" onerror="alert(1)">'


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    report = short_report()
    scene = replace(report.result.scene, title=HOSTILE)
    hostile = replace(report, result=replace(report.result, scene=scene))
    return write_page(hostile, tmp_path_factory.mktemp("page") / "report.html")


@pytest.fixture(scope="module")
def opened(browser, path):
    """A page with its cursor ready, what it told on the console, and the addresses it asked for."""
    tab = browser.new_page(viewport={"width": 1280, "height": 900}, color_scheme="dark")
    told, asked = [], []
    tab.on("console", lambda message: told.append(message.text))
    tab.on("pageerror", lambda error: told.append(str(error)))
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto(path.as_uri())
    tab.wait_for_selector("body[data-ready=yes]", timeout=30_000)
    yield tab, told, asked
    tab.close()


def test_nothing_is_told_on_the_console_and_nothing_asked_for(opened):
    tab, told, asked = opened
    assert told == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
    assert tab.title() == HOSTILE


def test_every_picture_is_drawn(opened):
    tab, *_ = opened
    axes = "p.querySelectorAll('.xaxislayer-above, .xy').length"
    drawn = tab.evaluate(f"[...document.querySelectorAll('.plot')].map(p => [p.id, {axes}])")
    assert len(drawn) > 8 and all(count > 0 for _, count in drawn)
    for name in ("orbit", "spectrum"):
        assert tab.evaluate(f"document.getElementById('{name}').data.length") > 0


def test_the_cursor_moves_the_orbit_and_its_line_through_all_pictures(opened):
    tab, *_ = opened
    state = """() => { const of = (name) => document.getElementById(name);
      return [of('orbit').data[1].x.slice(0, 5), of('campbell').layout.shapes[0].y0, of('amplitude').layout.shapes[0].x0,
              of('readout').textContent]; }"""
    tab.focus("#cursor")
    tab.keyboard.press("Home")
    wait_until(tab, lambda: tab.evaluate(state)[1] < 32.0)
    first = tab.evaluate(state)
    tab.keyboard.press("End")
    wait_until(tab, lambda: tab.evaluate(state)[1] > 55.0)
    last = tab.evaluate(state)
    assert first[0] != last[0] and first[1] == first[2] < last[1] == last[2]
    assert re.search(r"^3\d\.\d.*Hz.*agrees", first[3]) and re.search(r"^5\d\.\d.*Hz", last[3])


def test_the_button_moves_the_mode_shapes_and_puts_them_back(browser, tmp_path):
    report = rsc.check(rsc.Scene.from_toml(text()))
    tab = browser.new_page(viewport={"width": 400, "height": 900})
    told = []
    tab.on("console", lambda message: told.append(message.text))
    tab.goto(write_page(report, tmp_path / "shaft.html").as_uri())
    tab.wait_for_selector("body[data-ready=yes]", timeout=30_000)
    state = "['mode_1', 'mode_2'].map((name) => document.getElementById(name).data.map((trace) => trace.y.slice(0, 4)))"
    still, axis = tab.evaluate(state), tab.evaluate("document.getElementById('machine').data[0].y.slice(0, 4)")
    tab.click("#animate")
    wait_until(tab, lambda: tab.evaluate(state) != still)
    moved = tab.evaluate(state)
    assert moved[0] != still[0] and moved[1] != still[1] and moved[0][0] == still[0][0]  # all of them, but not their axes
    tab.click("#animate")
    wait_until(tab, lambda: tab.evaluate(state) == still)
    assert tab.evaluate("document.getElementById('machine').data[0].y.slice(0, 4)") == axis and told == []
    assert tab.evaluate("document.documentElement.scrollWidth") <= 400
    tab.close()


def test_the_run_plays_to_its_end_or_until_it_is_stopped(opened):
    tab, told, _ = opened
    at = "Number(document.getElementById('cursor').value)"
    tab.evaluate("const c = document.getElementById('cursor'); c.value = 0; c.dispatchEvent(new Event('input'))")
    orbit = "document.getElementById('orbit').data[1].x.slice(0, 5)"
    still = tab.evaluate(orbit)
    tab.click("#play")
    wait_until(tab, lambda: tab.evaluate(at) > 2 and tab.evaluate(orbit) != still)
    tab.click("#play")
    stopped = tab.evaluate(at)
    tab.wait_for_timeout(1500)
    assert tab.evaluate(at) == stopped and tab.inner_text("#play") == "Play the run"
    last = tab.evaluate("Number(document.getElementById('cursor').max)")
    tab.evaluate(f"const c = document.getElementById('cursor'); c.value = {last - 1}; c.dispatchEvent(new Event('input'))")
    tab.click("#play")
    wait_until(tab, lambda: tab.evaluate(at) == last and tab.inner_text("#play") == "Play the run")
    assert told == []


def test_the_path_at_the_cursor_is_that_of_the_run(opened):
    tab, *_ = opened
    tab.focus("#cursor")
    tab.keyboard.press("End")
    report = short_report()
    own = 1e3 * report.orbits.rotor[-1]  # mm, the unit of the page
    drawn = "(() => { const {x, y} = document.getElementById('orbit').data[1]; return [Array.from(x), Array.from(y)]; })()"

    def is_that_of_the_run():
        x, y = tab.evaluate(drawn)
        return len(x) == len(own) and np.abs(np.array(x) + 1j * np.array(y) - own).max() < 1e-3 * np.abs(own).max()

    wait_until(tab, is_that_of_the_run)


def wait_until(tab, holds):
    """Wait for a condition, some seconds at most; the page's policy forbids what the browser's own waiting needs."""
    for _ in range(100):
        if holds():
            return
        tab.wait_for_timeout(50)
    pytest.fail("the page did not answer")


def test_buttons_cover_no_legend_and_send_nothing_away(opened):
    tab, *_ = opened
    boxes = """() => [...document.querySelectorAll('.plot, #orbit')].map((place) => {
      const box = (name) => { const found = place.querySelector(name); return found ? found.getBoundingClientRect() : null; };
      const [bar, legend] = [box('.modebar-group'), box('.legend')];
      return [place.id, bar ? bar.left : 0, legend ? legend.right : 0]; })"""
    for name, bar, legend in tab.evaluate(boxes):
        assert bar > legend, name
    titles = tab.evaluate("[...document.querySelectorAll('.modebar-btn')].map((each) => each.dataset.title)")
    assert {title.split()[0] for title in titles} == {"Zoom", "Pan", "Reset", "Download"}


def test_a_whirl_can_be_chosen(opened):
    tab, *_ = opened
    tab.select_option("#whirl", "A")
    count = "document.getElementById('campbell').data.filter(t => {}).length"
    faint = tab.evaluate(count.format("t.meta && t.meta !== 'A' && t.opacity > 0.5"))
    clear = tab.evaluate(count.format("t.meta === 'A' && t.opacity < 1"))
    assert (faint, clear) == (0, 0)


def test_paper_has_every_section_and_picture(opened):
    tab, *_ = opened
    tab.emulate_media(media="print")
    shown = tab.evaluate("[...document.querySelectorAll('svg.static')].map(s => s.getBoundingClientRect().height)")
    assert len(shown) > 8 and min(shown) > 50
    assert tab.evaluate("getComputedStyle(document.querySelector('.controls')).display") == "none"
    paper = tab.pdf(format="A4")
    tab.emulate_media(media="screen")
    assert 4 <= len(re.findall(rb"/Type\s*/Page\b", paper)) <= 20


def test_a_phone_scrolls_in_one_direction(browser, path):
    tab = browser.new_page(viewport={"width": 390, "height": 800})
    tab.goto(path.as_uri())
    tab.wait_for_selector("body[data-ready=yes]", timeout=30_000)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    tab.close()


def test_without_script_the_page_is_whole(browser, path):
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(path.as_uri())
    assert tab.locator("svg.static").count() > 8 and tab.locator("svg.static").first.is_visible()
    assert not tab.locator(".controls").is_visible()
    assert "backward whirl, sliding at a rotor speed of" in tab.locator("dl").inner_text()
    context.close()

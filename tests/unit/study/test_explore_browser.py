"""The page of `rsc explore` in headless Chromium: it follows moves, undoes them and keeps them in its address, at two widths."""

import json
import time
from urllib.parse import unquote

import pytest

import rsc
from browsers import chromium, needs_chromium
from scenes import LAVAL, changed

pytestmark = needs_chromium
SCENE = rsc.Scene.from_dict(
    changed(LAVAL, title="<b>Laval</b>", drive={"speed": 50.0, "duration": 0.4}) | {"start": {"running": True}}
)
SLIDE = "([id, v]) => { const r = document.getElementById(id); r.value = v; r.dispatchEvent(new Event('input')); "
SLIDE += "r.dispatchEvent(new Event('change')); }"


@pytest.fixture(scope="module")
def browser():
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def page():
    rsc.simulate(SCENE)  # compiled before
    with rsc.explore(SCENE) as running:
        yield running


def opened(browser, address, width):
    tab, told = browser.new_page(viewport={"width": width, "height": 1000}), []
    tab.on("console", lambda message: told.append(message.text))
    tab.on("pageerror", lambda error: told.append(str(error)))
    tab.goto(address)
    tab.wait_for_selector("body[data-ready=yes]", timeout=60_000)
    return tab, told


def until(tab, expression, argument=None, limit=120.0):
    """Wait for an expression of the page; its policy forbids what playwright's own waiting does."""
    deadline = time.monotonic() + limit
    while not tab.evaluate(expression, argument):
        assert time.monotonic() < deadline, expression
        time.sleep(0.05)


def held(tab):
    return json.loads(unquote(tab.evaluate("location.hash.slice(1)")))


@pytest.mark.parametrize("width", [1400, 400])
def test_moves_are_followed_undone_and_kept_in_the_address(browser, page, width):
    tab, told = opened(browser, page.address, width)
    before, moves = tab.inner_text("#words"), int(tab.evaluate("document.body.dataset.moves"))
    tab.evaluate(SLIDE, ["range_contact.friction", 0.1])
    until(tab, f"+document.body.dataset.moves > {moves}")
    until(tab, "(text) => document.getElementById('words').textContent.trim() !== text.trim()", before)
    after = tab.inner_text("#words")
    assert held(tab)["contact.friction"] == pytest.approx(0.1, abs=2e-3)
    until(tab, "document.querySelectorAll('.late').length === 0")
    for picture in ("whirls", "orbit", "spectrum", "map"):
        assert tab.evaluate(f"document.getElementById('{picture}').querySelectorAll('.xaxislayer-above').length") >= 1, picture
    assert tab.evaluate("document.getElementById('whirls').data.some((trace) => trace.name === 'before')")
    again, said = opened(browser, tab.url, width)
    assert again.inner_text("#words") == after and said == []
    again.close()
    tab.click("#undo")
    until(tab, "(text) => document.getElementById('words').textContent.trim() === text.trim()", before)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.inner_text("#title") == "<b>Laval</b>" and tab.title().startswith("<b>Laval</b>") and told == []
    tab.close()


def test_another_value_is_found_by_its_name_and_a_scene_is_saved(browser, page):
    tab, told = opened(browser, page.address, 1400)
    tab.fill("#search", "rotor.mass")
    tab.click("#found button")
    tab.evaluate(SLIDE, ["range_rotor.mass", 2.0])
    with tab.expect_download() as waiting:
        tab.click("#save")
    text = waiting.value.path().read_text(encoding="utf-8")
    assert rsc.Scene.from_toml(text).rotor.mass == pytest.approx(2.0, abs=0.01) and told == []
    gap = "input[aria-label='contact.gap']"  # in mm; the address of the page keeps SI
    assert (tab.input_value(gap), tab.inner_text("label[for='range_contact.gap']")) == ("1", "contact.gap in mm")
    tab.fill(gap, "0.9")
    tab.press(gap, "Enter")
    until(tab, "decodeURIComponent(location.hash).includes('\"contact.gap\":0.0009')")
    tab.fill("input[aria-label='contact.gap']", "-1")
    tab.press("input[aria-label='contact.gap']", "Enter")
    until(tab, "document.getElementById('error').textContent.includes('contact.gap')")
    tab.close()


def test_the_list_is_made_in_the_background(browser, page):
    tab, told = opened(browser, page.address, 1400)
    tab.click("#list")
    until(tab, "document.getElementById('list_words').textContent.startsWith('Done')")
    assert "motion" in tab.inner_text("#listed") and told == []
    tab.close()

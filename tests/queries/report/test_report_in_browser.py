"""The report as its reader meets it: in a real browser, from a file, without a network."""

import io

import duckdb
import numpy as np
import pytest
from PIL import Image

from benchmarks.browser import start_browser
from benchmarks.runs.invented import Study
from queries.database import DATABASE, connect, ingest
from queries.report import write_report

pytestmark = pytest.mark.privileged

FIGURES = ("levels", "narrow", "force", "places", "heat", "distance", "cost", "receptance", "unevenness")
NAME = '"><img src=x onerror="alert(1)"><script>alert(2)</script>'


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with start_browser(tmp_path_factory.mktemp("playwright")) as browser:
        yield browser


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Return the report of a study with two of everything, whose names are hostile."""
    directory = Study(tmp_path_factory.mktemp("run") / "it's a run & more").write(
        soils=("horstwalde", NAME), speeds=(100.0, 150.0), lines=400, name=NAME
    )
    ingest(directory)
    with duckdb.connect(str(directory / DATABASE)) as connection:
        connection.execute("UPDATE bands SET mean_square = mean_square * 2 WHERE contribution = 'total'")
        connection.execute("UPDATE psd_lines SET value = value * 2 WHERE series_id IN (SELECT series_id "
        "FROM series "
                           "WHERE contribution = 'total')")  # fmt: skip
        connection.execute("UPDATE bands SET mean_square = mean_square * band_hz WHERE case_id LIKE '%-150'")
        for receiver, factor in (("rail", 1.5), ("ground", 1.2)):
            connection.execute(
                "UPDATE bands SET mean_square = mean_square * $1 WHERE approach <> 'full' AND receiver = $2",
                [factor, receiver],
            )
        for column in ("train", "track", "unevenness"):
            # Every case once more with another name on this axis, and 3 dB more.
            copied = f"case_id || '-{column}'"
            for table in ("run_cases", "case_units", "series", "bands"):
                more = ", mean_square * 2 AS mean_square" if table == "bands" else ""
                connection.execute(
                    f"INSERT INTO {table} SELECT * REPLACE ({copied} AS case_id{more}) FROM {table}"
                )
            connection.execute(
                f"INSERT INTO cases SELECT * REPLACE ({copied} AS case_id, '{column} 2' AS {column}) FROM "
                f"cases"
            )
            if column in ("train", "unevenness"):
                tables = ("vehicles",) if column == "train" else ("unevenness_bands",)
                for table in tables:
                    connection.execute(
                        f"INSERT INTO {table} SELECT * REPLACE ('{column} 2' AS {column}) FROM {table}"
                    )
        connection.execute("INSERT INTO receptances SELECT * REPLACE ('track 2' AS track) FROM receptances")
    with connect(directory) as connection:
        return write_report(connection, directory / "report.html")


@pytest.fixture(scope="module")
def said():
    """Return what the page says that it should not: errors, warnings, requests, dialogues."""
    return []


@pytest.fixture(scope="module")
def opened(browser, path, said):
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: said.append(f"error: {error}"))
    page.on("dialog", lambda dialog: (said.append(f"dialogue: {dialog.message}"), dialog.dismiss()))
    page.on(
        "request",
        lambda request: (
            None
            if request.url.startswith(("data:", "blob:")) or request.url == path.as_uri()
            else said.append(f"request: {request.url}")
        ),
    )
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-ready=yes]")
    yield page
    page.close()


RESET = """() => {
  window.initial ??= [...document.querySelectorAll("select")].map((each) => each.value);
  document.querySelectorAll("select").forEach((each, number) => { each.value = window.initial[number]; });
  document.querySelectorAll("input").forEach((each) => { each.checked = true; });
  document.querySelector("#select-quantity").dispatchEvent(new Event("change", { bubbles: true }));
  document.activeElement.blur();
  scrollTo(0, 0);
}"""


@pytest.fixture
def page(opened, said):
    """Return the page as it is when it has just been opened."""
    opened.set_viewport_size({"width": 1280, "height": 900})
    opened.emulate_media(media="screen")
    opened.evaluate(RESET)
    yield opened
    assert said == []


def drawn(page):
    return {name: page.locator(f"#plot-{name}").inner_html() for name in FIGURES}


def test_every_figure_is_drawn_and_not_blank(page):
    for name in FIGURES:
        plot = page.locator(f"#plot-{name}")
        plot.scroll_into_view_if_needed()
        picture = np.asarray(Image.open(io.BytesIO(plot.screenshot())).convert("RGB"))
        dark = np.mean(picture.min(axis=2) < 160)
        assert 0.003 < dark < 0.8, name
        assert "no results" not in plot.inner_text(), name


def test_names_are_shown_as_text(page):
    assert page.locator("h1").inner_text() == NAME
    assert page.locator("img").count() == 0
    page.select_option("#select-soil", "1")
    assert page.evaluate("document.querySelectorAll('main script').length") == 0
    assert NAME in page.locator("#shown").inner_text()
    page.select_option("#select-heat-rows", "soil")
    assert NAME in page.locator("#plot-heat").text_content()


EXPECTED = {
    "quantity": {"levels", "narrow", "heat", "cost"},
    "receiver": {"levels", "narrow", "heat"},
    "soil": {"levels", "force", "places", "distance", "receptance"},
    "speed_kmh": {"levels", "narrow", "force", "places", "distance", "receptance"},
    "train": {"levels", "force", "places", "distance"},
    "track": {"levels", "force", "places", "distance"},
    "unevenness": {"levels", "force", "places", "distance", "unevenness"},
    "contribution": {"levels", "narrow", "places", "distance"},
    "decibel": {"levels", "narrow", "places", "distance"},
    "band": {"distance"},
    "heat-approach": {"heat"},
    "heat-rows": {"heat"},
    "cost": {"cost"},
}


def test_there_is_no_selector_without_a_test(page):
    found = page.eval_on_selector_all("select", "all => all.map(each => each.id.replace('select-', ''))")
    assert sorted(found) == sorted(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_a_selector_changes_what_is_shown(page, name):
    before = drawn(page)
    options = page.eval_on_selector_all(f"#select-{name} option", "all => all.map(each => each.value)")
    chosen = page.locator(f"#select-{name}").input_value()
    page.select_option(f"#select-{name}", next(value for value in options if value != chosen))
    after = drawn(page)
    assert {figure for figure in FIGURES if before[figure] != after[figure]} >= EXPECTED[name]


def test_the_level_that_is_shown_is_that_of_the_database(page, path):
    page.select_option("#select-receiver", label="ground at 8 m")
    page.select_option("#select-decibel", label="1e-6 in/s (US VdB)")
    shown = page.evaluate(
        "(() => { const trace = document.getElementById('plot-levels').data.find(each => each.name === "
        "'full model');"
        " return Array.from(trace.y); })()"
    )
    with connect(path.parent) as connection:
        expected = connection.execute(
            "SELECT decibel(mean_square / 2.54e-8 ** 2) FROM bands WHERE case_id = 'case-0-100' "
            "AND approach = 'full' AND contribution = 'dynamic' AND offset_m = 8 ORDER BY band_hz"
        ).fetchall()
    np.testing.assert_allclose(shown, [row[0] for row in expected], atol=0.0051)


def test_an_approach_can_be_left_out(page):
    names = "document.getElementById('plot-levels').data.map(each => each.name)"
    assert "full model" in page.evaluate(names)
    page.locator("label.approach", has_text="full model").locator("input").uncheck()
    assert "full model" not in page.evaluate(names)


def test_a_table_sorts_by_number_and_back(page):
    table = page.locator("table.sortable").first
    heading = table.locator("th", has_text="mean [dB]")
    column = heading.evaluate("each => each.cellIndex")

    def values():
        cells = table.locator(f"tbody tr td:nth-child({column + 1})").all_inner_texts()
        return [float(cell) for cell in cells]

    before = values()
    table.locator("th", has_text="largest").locator("button").click()
    heading.locator("button").click()
    assert values() == sorted(before)
    assert heading.get_attribute("aria-sort") == "ascending"
    heading.locator("button").click()
    assert values() == sorted(before, reverse=True)
    assert heading.get_attribute("aria-sort") == "descending"
    words = table.locator("th").first
    words.locator("button").click()
    texts = table.locator("tbody tr td:first-child").all_inner_texts()
    assert texts == sorted(texts, key=[NAME, "horstwalde"].index)


CONTROLS = "a[href], select, input, button, [tabindex='0']"


def test_the_keyboard_reaches_every_control_and_works_it(page):
    page.evaluate(
        f"document.querySelectorAll(`{CONTROLS}`).forEach((each, number) => each.dataset.number = number)"
    )
    controls = page.locator(CONTROLS).count()
    reached = set()
    for _ in range(controls + 5):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.dataset.number"))
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none" or page.evaluate("document.activeElement === document.body")
    assert reached - {None} == {str(number) for number in range(controls)}
    before = drawn(page)["levels"]
    page.locator("#select-receiver").focus()
    page.keyboard.press("ArrowDown")
    assert drawn(page)["levels"] != before
    page.locator("table.sortable th button").nth(2).focus()
    page.keyboard.press("Enter")
    assert page.locator("table.sortable th").nth(2).get_attribute("aria-sort") == "ascending"


CONTRAST = """() => {
  const parse = (text) => (text.match(/[\\d.]+/g) ?? []).map(Number);
  const light = ([r, g, b]) => {
    const part = [r, g, b].map((value) => value / 255)
      .map((value) => (value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * part[0] + 0.7152 * part[1] + 0.0722 * part[2];
  };
  const ratio = (a, b) => {
    const [high, low] = [light(a), light(b)].sort((x, y) => y - x);
    return (high + 0.05) / (low + 0.05);
  };
  const background = (element) => {
    for (let each = element; each; each = each.parentElement) {
      const colour = parse(getComputedStyle(each).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return [colour];
    }
    return [[255, 255, 255]];
  };
  const cells = [[67, 147, 195], [146, 197, 222], [247, 247, 247], [244, 165, 130], [214, 96, 77]];
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    const text = walker.currentNode.textContent.trim();
    if (!text || element.closest("script, style, noscript, option")) continue;
    const style = getComputedStyle(element);
    if (style.visibility === "hidden" || element.getClientRects().length === 0) continue;
    const inside = element.closest("svg") !== null;
    const colour = parse(inside ? style.fill : style.color);
    const behind = element.closest(".heatmap-label") ? cells : background(element);
    const opacity = Number(style.opacity) * Number(style.fillOpacity || 1);
    found.push([opacity < 1 ? 0 : Math.min(...behind.map((each) => ratio(colour, each))), text]);
  }
  for (const button of document.querySelectorAll("th button")) {
    found.push([ratio(parse(getComputedStyle(button, "::after").color), [255, 255, 255]), "::after"]);
  }
  return found;
}"""


def test_no_text_has_less_contrast_than_4_5(page):
    page.set_viewport_size({"width": 1280, "height": 6000})
    found = page.evaluate(CONTRAST)
    assert len(found) > 300
    assert any(text == "::after" for _, text in found)
    assert [item for item in found if item[0] < 4.5] == []


def test_a_narrow_screen_has_no_sideways_scrolling(page):
    page.set_viewport_size({"width": 390, "height": 800})
    for _ in range(100):  # figures follow a resize after a while
        if page.evaluate("document.documentElement.scrollWidth") <= 390:
            break
        page.wait_for_timeout(200)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for name in FIGURES:
        assert page.locator(f"#plot-{name} svg.main-svg").first.bounding_box()["width"] <= 390


def test_print_has_all_figures_and_no_controls(page):
    assert len(page.pdf(format="A4")) > 50_000
    page.emulate_media(media="print")
    assert page.locator("form.controls").is_hidden()
    assert page.locator("#plot-levels").is_visible()
    assert page.locator("#shown").is_visible()

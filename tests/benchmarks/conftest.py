"""What every chart of a study must pass."""

import csv
import itertools
import json
from dataclasses import replace
from typing import NamedTuple

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from benchmarks import commands
from benchmarks.common.charts import LETTER_SIZE, NOTE_SIZE, WIDTH


def _check(figure):
    """Assert that a chart can be read on a page: letters, edges, and nothing over anything."""
    assert figure.get_figwidth() <= WIDTH
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    figure.draw_without_rendering()  # labels moved in the first layout settle in the second
    page = figure.bbox.padded(1.0)
    for text in figure.findobj(Text):
        if text.get_text().strip() and text.get_visible():
            least = NOTE_SIZE if text.get_fontfamily() == ["monospace"] else LETTER_SIZE
            assert text.get_fontsize() >= least, text
    texts = [*figure.texts, *figure.legends, figure._suptitle]
    for ax in figure.axes:
        texts += [ax.title, ax.xaxis.label, ax.yaxis.label]
    boxes = {
        each: each.get_window_extent().padded(-1.0)
        for each in texts
        if each is not None and not (isinstance(each, Text) and not each.get_text().strip())
    }
    for each, box in boxes.items():
        assert page.x0 <= box.x0, each
        assert page.y0 <= box.y0, each
        assert box.x1 <= page.x1, each
        assert box.y1 <= page.y1, each
    for (one, a), (other, b) in itertools.combinations(boxes.items(), 2):
        assert not a.overlaps(b), (one, other)


@pytest.fixture
def readable():
    """Return the check of a chart."""
    return _check


class Written(NamedTuple):
    """Text on the terminal, rows of the CSV table, JSON object, and page of a study."""

    out: str
    table: list[dict]
    data: dict
    page: str


def _save_without_layout(figure, *args, _save=Figure.savefig, **options):
    """Save a chart whose layout another test checks: it takes most of the time."""
    engine = figure.get_layout_engine()
    figure.set_layout_engine("none")
    _save(figure, *args, **options)
    figure.set_layout_engine(engine)


@pytest.fixture
def run_study(tmp_path, capsys, monkeypatch):
    """Return a function that runs the command of a study and reads what it has written."""
    monkeypatch.setattr(Figure, "savefig", _save_without_layout)

    def run(words, *options):
        study, page = commands.STUDIES[words], tmp_path / "page.md"
        places = [f"<!-- {name}:begin -->\n<!-- {name}:end -->\n" for name in study.regions]
        page.write_text("".join(places), encoding="utf-8")
        to_page = ["--page", str(page)] if places else []
        with pytest.raises(SystemExit) as left:
            commands.main([*words.split(), *options, "--output", str(tmp_path), *to_page])
        assert left.value.code == 0
        for name in study.charts:
            assert (tmp_path / f"{name}.png").stat().st_size > 5_000
        with (tmp_path / f"{study.name}.csv").open(encoding="utf-8") as file:
            table = list(csv.DictReader(file))
        data = json.loads((tmp_path / f"{study.name}.json").read_text(encoding="utf-8"))
        return Written(capsys.readouterr().out, table, data, page.read_text(encoding="utf-8"))

    return run


@pytest.fixture
def run_result(run_study, monkeypatch):
    """Return a function that writes a result as the command of its study does."""

    def run(words, result):
        done = replace(commands.STUDIES[words], run=lambda progress: result)
        monkeypatch.setitem(commands.STUDIES, words, done)
        return run_study(words)

    return run

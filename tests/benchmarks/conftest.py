"""What every chart of a study must pass."""

import itertools

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from benchmarks.common.charts import LETTER_SIZE, NOTE_SIZE, WIDTH


def _check(figure):
    """Assert that a chart can be read on a page: letters, edges, and nothing over anything."""
    assert figure.get_figwidth() <= WIDTH
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    canvas.draw()  # labels that moved in the first layout have settled in the second
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

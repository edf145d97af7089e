"""The page of the methods names every registered method, every option, and its default."""

import dataclasses

import pytest

from sjasim.anticipation.method import HUMANS_ONLY
from sjasim.core.registry import names, resolve

from .pages import table_rows, text_of

PAGE = "docs/methods.md"
HEADINGS = {
    "sia": "## SIA",
    "random-dancer": "## Random dancer",
    "eca": "## ECA",
    "metronome": "## Metronome",
    "learned": "## Learned",
}


def test_every_method_is_described():
    rows = table_rows(PAGE, "# Methods")
    assert set(rows) == {*names("anticipation"), HUMANS_ONLY}
    assert set(HEADINGS) == set(names("anticipation"))


@pytest.mark.parametrize("method", HEADINGS)
def test_every_option_is_described_with_its_default(method):
    fields = dataclasses.fields(resolve("anticipation", method).config)
    rows = table_rows(PAGE, HEADINGS[method])
    assert set(rows) == {field.name for field in fields}
    for field in fields:
        default = rows[field.name].strip("`")
        assert (default == field.default) if isinstance(field.default, str) else (float(default) == field.default)


def test_the_page_says_what_methods_answer():
    assert all(name in text_of(PAGE) for name in ("ScheduleCommand", "CancelCommand", "SetTimer"))

"""The page "Where to find what" names every room, and only files that exist."""

import re

from .pages import ROOT, table_rows, text_of

PAGE = "docs/developers/tree.md"


def test_every_room_is_named():
    rooms = {f"{path.parent.name}/" for path in (ROOT / "sjasim").glob("*/__init__.py")}
    assert rooms <= set(table_rows(PAGE, "## Rooms"))


def test_every_link_says_where_it_leads():
    pairs = re.findall(r"\[([\w/.]+)\]\(\.\./\.\./([\w/.]+)\)", text_of(PAGE))
    assert len(pairs) > 30
    for name, path in pairs:
        assert (ROOT / path).exists()
        assert path in (name, f"sjasim/{name}", f"{name}/__init__.py"), name

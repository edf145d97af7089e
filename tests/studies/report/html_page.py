"""A strict reader of a page: tags, identifiers, links, tables and text."""

from __future__ import annotations

from html.parser import HTMLParser

VOID = {"meta", "br", "hr", "link", "img", "input"}
"""Elements without an end."""


class HtmlPage(HTMLParser):
    """A page that has been read; ``faults`` says what is wrong with it.

    Attributes:
        faults: tags that do not match, identifiers that occur twice, links that lead nowhere or outside.
        tables: label -> rows of cells as text; the last row of heads is the first one.
        styles: label -> rows of the classes of the cells.
        text: all text that a reader sees.
        drawings: (title, description, number of shapes) of every drawing that is read aloud.
    """

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.faults: list[str] = []
        self.tables: dict[str, list[list[str]]] = {}
        self.styles: dict[str, list[list[str]]] = {}
        self.text = ""
        self.drawings: list[list] = []
        self._open: list[str] = []
        self._ids: list[str] = []
        self._anchors: list[str] = []
        self._label = ""
        self.feed(text)
        self.close()
        self._finish(text)

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        if len(values) < len(attrs):
            self.faults.append(f"{tag} has an attribute twice")
        if tag not in VOID:
            self._open.append(tag)
        if tag == "script":
            self.faults.append("a script")
        self._note(tag, values)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag):
        if not self._open or self._open[-1] != tag:
            self.faults.append(f"</{tag}> at {self.getpos()} closes {self._open[-1:]}")
            return
        self._open.pop()

    def handle_data(self, data):
        if "style" in self._open:
            return
        if "svg" in self._open and self.drawings and self._open[-1] in ("title", "desc"):
            self.drawings[-1][self._open[-1] == "desc"] = data
        if self._open[-1:] in (["td"], ["th"]):
            self.tables[self._label][-1][-1] += data
        self.text += data

    def _note(self, tag, values):
        """Collect what an element tells about the page."""
        if "id" in values:
            self._ids.append(values["id"])
        for name in ("href", "src", "xlink:href", "action", "data"):
            target = values.get(name)
            if target is not None and target.startswith("#"):
                self._anchors.append(target[1:])
            elif target is not None:
                self.faults.append(f"{tag} leads outside: {target}")
        if tag == "svg" and values.get("role") == "img":
            self.drawings.append(["", "", 0])
        elif "svg" in self._open and tag in ("path", "rect", "line", "circle") and self.drawings:
            self.drawings[-1][2] += 1
        self._note_table(tag, values)

    def _note_table(self, tag, values):
        if tag == "table":
            self._label = values["aria-label"]
            self.tables[self._label] = []
            self.styles[self._label] = []
        elif tag == "tr" and values.get("class") == "above":
            self.tables[self._label].append([])
            self.styles[self._label].append([])
        elif tag == "tr":
            # A line above the heads is not a row of its own.
            if len(self.tables[self._label]) == 1 and "tbody" not in self._open:
                self.tables[self._label].clear()
                self.styles[self._label].clear()
            self.tables[self._label].append([])
            self.styles[self._label].append([])
        elif tag in ("td", "th"):
            self.tables[self._label][-1].append("")
            self.styles[self._label][-1].append(values.get("class", ""))

    def _finish(self, text):
        if self._open:
            self.faults.append(f"not closed: {self._open}")
        if len(set(self._ids)) < len(self._ids):
            self.faults.append(f"identifiers twice: {sorted({i for i in self._ids if self._ids.count(i) > 1})}")
        self.faults += [f"#{anchor} leads nowhere" for anchor in self._anchors if anchor not in self._ids]
        self.faults += [word for word in ("http://", "https://", "@import", "url(", "javascript:") if word in text]
        if not text.startswith("<!doctype html>"):
            self.faults.append("no doctype")


def read_page(path) -> HtmlPage:
    """The page in a file, which must be without faults."""
    page = HtmlPage(path.read_text(encoding="utf-8"))
    assert page.faults == []
    assert page.tables
    return page

"""Links of all pages, and what the README promises."""

import re
import tomllib

import pytest

from sjasim.choreography.timetable import timetable
from sjasim.config import FAULTS, SessionConfig
from sjasim.config.toml_file import from_plain
from sjasim.session.dancers import make_human_timing
from sjasim.studies.design_file import design_from_plain

from .pages import ROOT, blocks, links, pages, text_of

MOST_WORDS = 700


@pytest.mark.parametrize("page", pages())
def test_links_lead_to_files(page):
    folder = (ROOT / page).parent
    missing = [file for file in links(page) if not (folder / file).exists()]
    # The pages of the API reference are made when the site is built.
    assert [file for file in missing if not file.startswith("reference/api")] == []


def test_the_readme_is_short():
    words = text_of("README.md").split()
    assert 300 < len(words) <= MOST_WORDS


def test_the_readme_leads_to_every_page_of_the_site_that_users_need():
    linked = {file.removeprefix("docs/") for file in links("README.md")}
    needed = {
        "quick-start.md",
        "concepts.md",
        "glossary.md",
        "paper.md",
        "session-folder.md",
        "methods.md",
        "people.md",
    }
    needed |= {"environment.md", "own-data.md", "plug-ins.md", "figures.md", "troubleshooting.md", "developers/tree.md"}
    assert needed <= linked


def test_settings_in_a_file_are_understood():
    settings, *_ = blocks("docs/quick-start.md", "toml")
    config = from_plain(tomllib.loads(settings.text))
    assert [fault.kind for fault in config.faults] == ["clock_jump", "dancer_late"]
    text = text_of("docs/quick-start.md")
    assert all(f"`{kind}`" in text or f'"{kind}"' in text for kind in FAULTS)


def test_the_design_of_the_page_about_studies_is_understood():
    (design,) = blocks("docs/study.md", "toml")
    plan = design_from_plain(tomllib.loads(design.text))
    assert (plan.groups, plan.session.dancers, len(plan.factors)) == (20, 4, 2)


def test_each_page_has_one_title():
    for page in pages():
        text = re.sub(r"```.*?```", "", text_of(page), flags=re.DOTALL)
        titles = re.findall(r"^# .+", text, re.M)
        assert len(titles) == (
            0 if page in ("docs/developers/contributing.md", "docs/developers/changelog.md") else 1
        ), page


def test_the_paper_page_names_every_equation():
    rows = text_of("docs/paper.md")
    for equation in range(1, 12):
        spans = re.findall(r"eqs?\. \((\d+)\)(?: (?:to|and) \((\d+)\)|, \((\d+)\))?", rows)
        named = {n for first, last, other in spans for n in range(int(first), int(last or other or first) + 1)}
        assert equation in named


def test_quoted_messages_are_messages_of_the_code():
    """Every message that Troubleshooting quotes stands in a source file."""
    shipped = [path for folder in ("sjasim", "scripts") for path in (ROOT / folder).rglob("*.py")]
    sources = " ".join(path.read_text(encoding="utf-8") for path in shipped)
    text = text_of("docs/troubleshooting.md")
    quoted = re.findall(r"^`(.+)`\n:", text, re.M) + re.findall(r"^\| `(.+?)` \|", text, re.M)
    assert len(quoted) >= 7
    assert [message for message in quoted if message not in sources] == []


def test_the_glossary_is_in_order():
    rows = [line for line in text_of("docs/glossary.md").splitlines() if line.startswith("| ")][1:]
    names = [row.split(" | ")[0].strip("| *").lower() for row in rows]
    assert len(names) > 60
    assert names == sorted(set(names))


def test_the_file_of_another_model_of_people_is_understood(tmp_path):
    page = blocks("docs/people.md", "toml")
    text = next(block.text for block in page if block.text.startswith("model"))
    path = tmp_path / "people.toml"
    path.write_text(text, encoding="utf-8")
    config = SessionConfig(humans=str(path))
    assert type(make_human_timing(config, timetable(config))).__name__ == "AdamTiming"

"""Which folders have a page, where it is written, and what is refused."""

import pytest

from sjasim.core.errors import RecordError
from sjasim.studies.report.folders import REPORT, write_report

from .html_page import read_page


def test_the_page_lies_in_the_folder_or_where_it_is_wanted(folder_of, paper_study, tmp_path):
    folder = folder_of("study.json", paper_study)
    assert write_report(folder) == folder / REPORT
    elsewhere = write_report(folder, tmp_path / "page.html")
    assert elsewhere.read_bytes() == (folder / REPORT).read_bytes()
    assert {path.name for path in folder.iterdir()} == {"study.json", REPORT}


def test_an_earlier_page_stays_unless_it_may_be_replaced(folder_of, paper_study):
    folder = folder_of("study.json", paper_study)
    (folder / REPORT).write_text("mine", encoding="utf-8")
    with pytest.raises(RecordError, match="--overwrite"):
        write_report(folder)
    assert (folder / REPORT).read_text(encoding="utf-8") == "mine"
    read_page(write_report(folder, overwrite=True))


@pytest.mark.parametrize("name", ["study.json", "session.json", "reproduce.json", "characterise.json", "power.json"])
@pytest.mark.parametrize(
    ("content", "words"),
    [("[]", "is not of version"), ("{", "is damaged"), ('{"schema": 99}', "is not of version"), ('{"schema": 1}', "")],
)
def test_a_file_that_is_not_the_commands_own_is_refused(tmp_path, name, content, words):
    (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(RecordError) as raised:
        write_report(tmp_path)
    assert name in str(raised.value)
    assert words in str(raised.value)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_folder_of_another_kind_is_refused(tmp_path):
    with pytest.raises(RecordError, match="it has none of study"):
        write_report(tmp_path)
    with pytest.raises(RecordError, match="there is no such folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(RecordError, match="its folder does not exist"):
        write_report(tmp_path, tmp_path / "nowhere" / "page.html")


def test_names_from_files_are_escaped_and_shortened(folder_of, paper_study):
    design = {**paper_study["design"], "humans": ["<i>people</i>", "/a/very/long/path/to/a/folder/of/people.toml"]}
    page = read_page(write_report(folder_of("study.json", {**paper_study, "design": design})))
    assert "<i>people</i>" in page.text
    assert "/a/very/long/path/to…people.toml" in page.text.replace(" ", "")


def test_a_page_is_the_same_each_time(folder_of, paper_study):
    folder = folder_of("study.json", paper_study)
    first = write_report(folder).read_bytes()
    assert write_report(folder, overwrite=True).read_bytes() == first

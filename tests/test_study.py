"""The command `study`: one small study, its plan, and bad input."""

import json

import pytest

from sjasim import study
from sjasim.commands.main import main
from sjasim.studies.dataset import read_study

SMALL = ("--groups", "2", "--iterations", "2", "--dance.no-rehearsal")


def test_a_small_study_prints_its_conditions_and_writes_a_data_set(tmp_path, capsys):
    folder = tmp_path / "study"
    arguments = [*SMALL, "--methods", "eca", "sia", "--out", str(folder)]
    assert main(study.command, arguments) == 0
    said = capsys.readouterr()
    assert "2 groups, 6 sessions, timing fidelity, paper-entrainment" in said.out
    assert max(map(len, said.out.splitlines())) <= 80
    assert [line.split()[1] for line in said.out.splitlines() if line.startswith("│")] == ["none", "eca", "sia"]
    assert said.out.startswith("sia against eca: no difference of GSI is shown, no difference of TA is shown\n")
    assert "too few for pseudo-groups" in said.out
    assert "Wilcoxon by step: z = " in said.out
    assert f"study written to {folder}" in said.err
    assert read_study(folder).sessions["order"].tolist() == [1, 2, 3, 1, 2, 3]
    assert "ECA and SIA in 2 groups" in (folder / "report.html").read_text(encoding="utf-8")

    # Without options of its own, --resume takes the design from the folder.
    assert main(study.command, ["--resume", "--out", str(folder), "--json"]) == 0
    results = json.loads(capsys.readouterr().out)
    assert results == json.loads((folder / "study.json").read_text(encoding="utf-8"))
    assert results["design"]["groups"] == 2


def test_a_design_file_factors_and_options_of_several_methods_come_together(tmp_path, capsys):
    file = tmp_path / "design.toml"
    file.write_text('groups = 3\nmethods = ["sia", "metronome"]\n[session]\niterations = 2\n', encoding="utf-8")
    arguments = ["--design", str(file), "--groups", "2", "--factors", "network.packet-loss=0,0.5"]
    arguments += ["--method-options.window-s", "1.2", "--no-humans-only", "--json"]
    assert main(study.command, arguments) == 0
    results = json.loads(capsys.readouterr().out)
    design = results["design"]
    assert (design["groups"], design["session"]["iterations"]) == (2, 2)
    assert design["session"]["method_options"] == {"window_s": 1.2}
    assert design["factors"] == {"network.packet_loss": [0, 0.5]}
    assert results["session_count"] == 8
    assert [row["condition"] for row in results["by_condition"]] == [
        "sia network.packet_loss=0", "sia network.packet_loss=0.5",
        "metronome network.packet_loss=0", "metronome network.packet_loss=0.5",
    ]  # fmt: skip


def test_a_dry_run_prints_the_price_and_writes_nothing(tmp_path, capsys):
    folder = tmp_path / "study"
    arguments = ["--groups", "100000", "--humans", "paper-warmup", "musicians", "--dry-run", "--jobs", "2"]
    assert main(study.command, [*arguments, "--out", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "600,000 sessions: about " in said
    assert "2 combinations of humans" in said
    assert " GB on disk" in said
    assert not folder.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--groups", "1"), "groups = 1"),
        (("--methods", "siaa"), "no method named 'siaa'"),
        (("--methods", "sia", "sia"), "methods"),
        (("--humans", "nobody"), "no humans preset named 'nobody'"),
        (("--dances", "tango"), "no dance named 'tango'"),
        (("--factors", "dance.bpm=118"), "one level changes nothing"),
        (("--factors", "dance.bpm"), "NAME=LEVEL"),
        (("--factors", "robot.colour=1,2"), "robot.colour"),
        (("--method", "eca"), "--methods"),
        (("--order", "latin"), "order"),
        (("--backend", "spark"), "backend"),
        (("--method-options.speed", "1"), "method-options.speed"),
        (("--design", "nowhere.toml"), "nowhere.toml"),
        (("--config", "{here}/lab.toml"), "session.method"),
        (("--out", "/proc/nowhere/x"), "cannot be written"),
        (("--out", "{here}"), "holds no study"),
        (("--resume", "--out", "{here}"), "holds no study"),
        (("--groups", "9000000", "--replications", "9000"), "on disk, and"),
    ],
)
def test_bad_input_is_one_line(capsys, tmp_path, arguments, words):
    (tmp_path / "lab.toml").write_text('method = "sia_of_my_own"', encoding="utf-8")
    assert main(study.command, [word.format(here=tmp_path) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_the_help_fits_and_names_every_field_of_the_design(capsys):
    with pytest.raises(SystemExit) as ended:
        main(study.command, ["--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    for flag in (
        "--groups",
        "--methods",
        "--order",
        "--humans",
        "--replications",
        "--missing",
        "--backend",
        "--resume",
    ):
        assert flag in text
    assert "--method-options.window-s" in text
    assert "--dance.bpm" in text
    assert "--performance" in text
    assert "--dance.name" not in text

"""The command line of a page gives the session that it reports."""

import shlex

from sjasim.commands.session_options import parse_session
from sjasim.config import SessionConfig
from sjasim.config.faults import FaultConfig
from sjasim.config.toml_file import from_plain, to_plain
from sjasim.run import FIRST, Options
from sjasim.studies.report.command_lines import changed_fields, has_unnamed_fields, session_command

CONFIG = from_plain({
    "method": "sia", "seed": 7, "humans": "my people.toml", "sensing": "joints", "method_options": {"window_s": 1.5},
    "dance": {"name": "march", "rehearsal": False, "tempo": [[80.0, 1.0], [160.0, 1.2]]},
    "network": {"packet_loss": 0.2},
})  # fmt: skip


def test_the_line_is_read_as_the_same_configuration():
    program, command, *arguments = shlex.split(session_command(to_plain(CONFIG)))
    assert (program, command) == ("sjasim", "run")
    options = parse_session(Options, arguments, "sjasim run", "about", FIRST)
    assert options.session == CONFIG
    assert str(options.outputs.out) == "DIR"


def test_only_what_differs_is_named():
    assert changed_fields(to_plain(SessionConfig())) == {}
    assert session_command(to_plain(SessionConfig())) == "sjasim run --method sia --seed 0 --out DIR"


def test_faults_have_no_flags():
    config = to_plain(SessionConfig(faults=(FaultConfig(kind="dancer_late", target="dancer_1", t_s=10.0),)))
    assert has_unnamed_fields(config)
    assert "fault" not in session_command(config)
    assert not has_unnamed_fields(to_plain(CONFIG))

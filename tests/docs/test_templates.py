"""The templates of plug-ins keep their contracts, and a session runs with each of them."""

import dataclasses

import numpy as np
import pytest

from sjasim.anticipation.method import build_method
from sjasim.choreography.score import Choreography
from sjasim.choreography.timetable import timetable
from sjasim.config import BodyConfig, SessionConfig
from sjasim.config.toml_file import from_plain
from sjasim.core.method_io import MethodContext, ScheduleCommand
from sjasim.core.registry import resolve
from sjasim.humans.body.anatomy import Build
from sjasim.humans.timing.human_timing import HumanTiming
from sjasim.session.dancers import make_human_timing
from sjasim.session.session import run_session

from .pages import EXAMPLES, text_of

TEMPLATES = {
    "method": "follow_first:FollowFirst",
    "dance": "there_and_back:there_and_back",
    "people": "independent_people:IndependentPeople",
    "body": "grey_body:GreyBody",
    "sensor": "perfect_sensor:PerfectSensor",
}

QUICK = SessionConfig(humans="musicians", sensing="joints", iterations=1)


@pytest.fixture(autouse=True)
def _importable(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))


@pytest.fixture
def context_and_log(make_session_log):
    log = make_session_log(iterations=2, joints=False)
    table = timetable(from_plain(log.config))
    numbers = range(3)
    context = MethodContext(
        cast=("dancer_1", "dancer_2", "dancer_3"),
        steps=table.choreography.steps(),
        iterations=2,
        beat_s=60 / 118,
        iteration_start_s=tuple(table.start_s(number) for number in numbers),
        window_end_s=tuple(table.close_s(number) for number in numbers),
    )
    return context, log


def test_the_page_has_every_template():
    page = text_of("docs/plug-ins.md")
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {name.partition(":")[0] for name in TEMPLATES.values()} | {
        "train"
    }
    for name in TEMPLATES.values():
        assert f"examples/{name.partition(':')[0]}.py" in page
        assert f" {name}\n" in page


@pytest.mark.parametrize("dancer", ["dancer_1", "dancer_3"])
def test_the_method_commands_every_step_once_seen(context_and_log, dancer):
    context, log = context_and_log
    method = build_method(TEMPLATES["method"], {"dancer": dancer})
    method.reset(context, np.random.default_rng(0))

    events = sorted(log.events, key=lambda event: event.t_arrival_s)
    actions = [action for event in events for action in method.on_event(event)]
    assert all(isinstance(action, ScheduleCommand) and action.person == dancer for action in actions)
    assert [(action.iteration, action.ordinal) for action in actions] == [(i, k) for i in (1, 2) for k in range(9)]
    assert list(method.on_iteration_start(1, 0.0)) == list(method.on_iteration_end(1, 0.0)) == []
    assert list(method.on_timer(0.0)) == []


def test_the_dance_has_five_events():
    dance = resolve("choreography", TEMPLATES["dance"]).factory()
    assert isinstance(dance, Choreography)
    kinds = [step.kind.value for step in dance.steps()]
    assert kinds == ["start_forward", "stop_forward", "start_backward", "stop_backward", "clap"]


def test_the_people_decide_every_move_of_every_dancer():
    config = dataclasses.replace(QUICK, humans=TEMPLATES["people"])
    table = timetable(config)
    people = make_human_timing(config, table)
    assert isinstance(people, HumanTiming)

    people.begin(1, None, np.zeros(3))
    cues = people.decide(people.next_due_s, ())
    assert np.isinf(people.next_due_s)
    for dancer, own in enumerate(cues, start=1):
        assert [cue.move for cue in own] == [item.move for item in table.choreography.moves]
        assert {cue.dancer for cue in own} == {f"dancer_{dancer}"}
        assert all(abs(cue.t_s - table.time_s(1, cue.beat)) < 0.6 for cue in own)


def test_the_body_is_the_default_one_in_grey():
    grey = resolve("body", TEMPLATES["body"]).factory()
    spec = grey.spec(grey.anatomy(Build()), 0, 1, BodyConfig())
    assert len(spec.geoms) > 20
    assert all(np.allclose(geom.rgba, (0.6, 0.6, 0.6, 1.0)) for geom in spec.geoms)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"method": TEMPLATES["method"]},
        {"dance": dataclasses.replace(QUICK.dance, name=TEMPLATES["dance"])},
        {"humans": TEMPLATES["people"]},
        {"body": dataclasses.replace(QUICK.body, model=TEMPLATES["body"])},
        {"sensing": TEMPLATES["sensor"]},
    ],
    ids=list(TEMPLATES),
)
def test_a_session_runs_with_it(changes):
    log = run_session(dataclasses.replace(QUICK, **changes))
    regular = [event for event in log.events if event.iteration == 1 and not event.early]
    # Three dancers with five events each in the short dance, and with nine in the paper's; few are missed.
    assert len(regular) >= (14 if "dance" in changes else 24)
    assert len(log.robot_events) >= (4 if "dance" in changes else 8)

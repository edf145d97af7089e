"""Tables of joints in the formats of laboratories: what is read, what is refused, and the error messages."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sjasim.core.errors import RecordError
from sjasim.record.joint_table import read_joints

HEAD = "t_s,person,joint,x_m,y_m,z_m\n"


def read(tmp_path, text: str, encoding: str = "utf-8"):
    path = tmp_path / "joints.csv"
    path.write_bytes(text.encode(encoding))
    return read_joints(path)


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "0.5,1,SpineBase,-0.1,0.2,2.5\n0.5,1,SpineMid,,nan,NA\n",
        "\ufeff" + HEAD + "0.5,1,0,-0.1,0.2,2.5\n",
        '"t_s","person","joint","x_m","y_m","z_m"\n"0.5","1","spine_base","-0.1","0.2","2.5"\n',
        "z_m;y_m;x_m;joint;T_S;Person;State\n2,5;0,2;-0,1;SPINEBASE;0,5;1;2\n;;;1;0,5;1;\n",
        "State\tz_m\ty_m\tx_m\tjoint\tt_s\tperson\nTracked\t2.5\t0.2\t-0.1\t0\t0.5\t1\n",
    ],
)
def test_all_formats_give_the_same_joints(tmp_path, text):
    found = read(tmp_path, text)
    assert found.t_s.tolist() == [0.5]
    assert found.persons.tolist() == [1]
    assert found.joints_m[0, 0, 0].tolist() == [-0.1, 0.2, 2.5]
    assert np.isnan(found.joints_m[0, 0, 1:]).all()
    assert found.state[0, 0, 0] == 2


@pytest.mark.parametrize(
    ("word", "code"), [("tracked", 2), ("Inferred", 1), ("NotTracked", 0), ("not_tracked", 0), ("1", 1), ("2", 2)]
)
def test_a_state_is_a_word_or_a_number(tmp_path, word, code):
    found = read(tmp_path, HEAD.strip() + f",state\n0,1,SpineBase,0,0,2,{word}\n")
    assert found.state[0, 0, 0] == code


def test_persons_are_numbers_or_names(tmp_path):
    rows = "0,{},SpineBase,0,0,2\n"
    names = read(tmp_path, HEAD + "".join(map(rows.format, ("P10", "P2", "ana")))).persons.tolist()
    assert names == ["P2", "P10", "ana"]
    # The Kinect's tracking ids are too large to be exact as floats.
    tracking = [72057594037927938, 72057594037927937]
    assert read(tmp_path, HEAD + "".join(map(rows.format, tracking))).persons.tolist() == sorted(tracking)


def test_parquet_columns_may_have_any_type(tmp_path):
    path = tmp_path / "joints.parquet"
    joints = pa.array(["SpineBase", "SpineMid"]).dictionary_encode()
    columns = {"t_s": [0.0, 0.0], "person": [1.0, 1.0], "joint": joints,
               "x_m": [0.0, None], "y_m": [0, 1], "z_m": [2, 2], "state": [2, 1]}  # fmt: skip
    pq.write_table(pa.table(columns), path)
    found = read_joints(path)
    assert found.persons.tolist() == [1]
    assert found.state[0, 0, :2].tolist() == [2, 1]
    assert np.isnan(found.joints_m[0, 0, 1, 0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,person,SpineBase_x\n0,1,2\n", "no column t_s, joint, x_m, y_m, z_m; .*; it has t, person, spinebase_x"),
        ("", "it has nothing"),
        (HEAD + "0,1.5,SpineBase,0,0,2\n", "line 2, person: '1.5', expected a whole number or a name"),
        (HEAD + "0,,SpineBase,0,0,2\n", "line 2, person: nothing"),
        (HEAD + "0,1,25,0,0,2\n", "line 2, joint: '25'"),
        (HEAD + "0,1,0,0,0,2\n,1,0,0,0,2\n", "line 3, t_s: nothing, expected a finite number"),
        (HEAD + "0,1,0,0,0,2\n0,1,SpineBase,0,0,2\n", "line 3, joint: 'SpineBase', expected each joint once"),
        (HEAD + "0,1,SpineBase,0,0\n", "cannot be read as a table: .*Expected 6 columns, got 5"),
        ("t_s;person;joint;x_m;y_m;z_m\n0;1;0;1,000,5;0;2\n", "line 2, x_m: '1.000.5', expected a number"),
        (HEAD.strip() + ",state\n0,1,0,0,0,2,\n", "line 2, state: nothing"),
    ],
)
def test_an_invalid_table_gives_an_error_that_names_the_cell(tmp_path, text, words):
    with pytest.raises(RecordError, match=words):
        read(tmp_path, text)


def test_other_encodings_and_absent_files_are_refused(tmp_path):
    with pytest.raises(RecordError, match="its text is not UTF-8"):
        read(tmp_path, HEAD, "utf-16")
    with pytest.raises(RecordError, match="does not exist"):
        read_joints(tmp_path / "nothing.csv")

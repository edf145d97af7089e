"""The package's public names."""

import re
import subprocess
import sys

import pytest

import sjasim


@pytest.mark.parametrize("name", sjasim.__all__)
def test_every_public_name_can_be_imported(name):
    assert getattr(sjasim, name) is not None
    assert name in dir(sjasim)


def test_a_star_import_gives_the_public_names():
    code = "from sjasim import *; import sjasim; print([name for name in sjasim.__all__ if name not in globals()])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_the_public_names_are_those_that_the_package_documents():
    documented = re.findall(r"^    (\w+): ", sjasim.__doc__, re.M)
    assert sorted(documented) == sorted(sjasim.__all__)


def test_another_name_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        sjasim.nothing  # noqa: B018

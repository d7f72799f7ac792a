"""What tests of several packages look at."""

from tests.conftest import calm_bag  # noqa: F401 - a fixture

"""What tests of logs of others look at beside the bags' own tests."""

from bags.test.conftest import made_up_bag, shared_bag  # noqa: F401 - fixtures

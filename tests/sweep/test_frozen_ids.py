import json

import pytest

from tests.data.unit_ids import FROZEN, resolved_studies, unit_ids


@pytest.mark.parametrize(("name", "resolved"), resolved_studies().items())
def test_ids_of_stored_results_stay(name, resolved):
    """A stored result is found again only if the inputs that its id is made of keep their form."""
    assert unit_ids(resolved) == json.loads(FROZEN.read_text(encoding="utf-8"))[name]

from queries.answers.approaches import in_order, label, reference, requested_approaches


def test_the_reference_comes_after_what_is_compared_with_it_and_unknown_ones_last():
    names = ["of-tomorrow", "full", "another", "moving-roughness", "full"]
    assert in_order(names) == ["moving-roughness", "full", "another", "of-tomorrow"]


def test_unknown_approaches_are_called_by_their_names():
    assert label("full") == "full model"
    assert label("of-tomorrow") == "of-tomorrow"


def test_approaches_of_a_study(results):
    assert requested_approaches(results) == ["moving-roughness", "moving-roughness-uncorrelated", "full"]
    assert reference(results) == "full"

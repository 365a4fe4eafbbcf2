import pytest

from tests.sweep.small import STUDY, invoke


@pytest.fixture(scope="session")
def computed(tmp_path_factory):
    """Return a directory with the small study and, as `out`, its run in this process."""
    folder = tmp_path_factory.mktemp("computed")
    (folder / "small.toml").write_text(STUDY, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sweep.hooks.AFTER_RUN", "none")
        result = invoke("run", folder / "small.toml", "--out", folder / "out", "--workers", 0)
    assert result.exit_code == 0, result.output
    return folder


@pytest.fixture
def study_folder(tmp_path, monkeypatch):
    """Return the working directory with the small study; nothing is published after a run."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sweep.hooks.AFTER_RUN", "none")
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path

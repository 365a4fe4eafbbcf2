from tests.sweep.conftest import computed

__all__ = ["computed"]

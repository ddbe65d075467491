"""All tests of the package; then whether they called every function of the C interface.

    python tests/python/test_reach.py
"""

import unittest

import test_answers
import test_edges
import test_images
import test_package
from moulage import interface, native

WAITS = "a run that is started and waited for does the same and hears Ctrl-C"
NAMES = "its names are in interface.py, made from the header"
NOT_CALLED = {
    "tetrahedralization_run": WAITS,
    "reshaping_run": WAITS,
    "registration_run": WAITS,
    "separation_run": WAITS,
    "status_name": NAMES,
    "stop_name": NAMES,
    "concern_name": NAMES,
    "severity_name": NAMES,
    "verdict_name": NAMES,
    "ending_name": NAMES,
    "abi_version": "called by native.py while it loads the library",
}


class Recorder:
    """The library, and the names that were asked of it."""

    def __init__(self, loaded):
        self._loaded, self.asked = loaded, set()

    def __getattr__(self, name):
        self.asked.add(name.removeprefix("mlg_"))
        return getattr(self._loaded, name)


if __name__ == "__main__":
    recorder = native._loaded = Recorder(native.library())
    suite = unittest.TestSuite(
        unittest.defaultTestLoader.loadTestsFromModule(module) for module in (test_package, test_answers, test_images, test_edges)
    )
    result = unittest.TextTestRunner().run(suite)
    assert result.wasSuccessful()
    missing = interface.CALLS.keys() | interface.GETTERS.keys()
    missing -= recorder.asked
    assert missing == NOT_CALLED.keys(), f"not called: {missing - NOT_CALLED.keys()}; called: {NOT_CALLED.keys() - missing}"
    print(f"{len(recorder.asked)} functions called from Python")

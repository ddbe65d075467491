"""Every public member of the package has documentation that numpydoc accepts, and tells all parameters and results.

    python tests/python/documented.py
"""

import inspect
import sys

from numpydoc.validate import validate

import moulage

# No documentation, unknown or missing parameters, no type, no result, wrong sections, no summary, a summary that is no sentence.
ASKED = {"GL06", "GL07", "GL08", "PR01", "PR02", "PR03", "PR04", "PR10", "RT01", "RT02", "SS01", "SS02", "SS03", "SS04", "YD01"}
# Classes that nobody but the package constructs.
GIVEN = {"Error", "Pairs", "RegistrationResult", "ReshapingResult", "Run", "SeparationResult", "Uncertainty"}


def members():
    """Names of all that a user may call or read."""
    for name in moulage.__all__:
        thing = getattr(moulage, name)
        if not (inspect.isclass(thing) or inspect.isfunction(thing)):
            continue
        yield f"moulage.{name}"
        if inspect.isclass(thing):
            for own, value in vars(thing).items():
                if not own.startswith("_") and (callable(value) or isinstance(value, (classmethod, property))):
                    yield f"moulage.{name}.{own}"


def faults():
    for name in members():
        for code, words in validate(name)["errors"]:
            if code in ASKED and not (code == "PR01" and name.removeprefix("moulage.") in GIVEN):
                yield f"{name}: {code} {words}"


if __name__ == "__main__":
    found, count = list(faults()), len(list(members()))
    print("\n".join(found))
    print(f"{count} members are documented" if not found else f"{len(found)} faults")
    sys.exit(bool(found))

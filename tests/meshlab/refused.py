"""A filter built for another MeshLab is refused with MeshLab's own words: refused.py PLUGIN WORDS"""

import sys

import pymeshlab

try:
    pymeshlab.load_plugin(sys.argv[1])
except pymeshlab.PyMeshLabException as error:
    assert sys.argv[2] in str(error), error
    print("refused:", str(error).strip().splitlines()[-1])
else:
    sys.exit("the filter was loaded although it does not fit")

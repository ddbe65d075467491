"""What a caller may do wrong with numbers, copies, processes and runs: refused or ended, never something else in silence.

    python tests/python/test_edges.py
"""

import copy
import os
import pickle
import signal
import threading
import time
import unittest

import moulage
from test_package import cube, long_run


def _interrupt_main_when(ready):
    """Ctrl-C, as the terminal sends it."""
    while not ready():
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)


class Edges(unittest.TestCase):
    def setUp(self):
        self.points, self.triangles = cube()
        self.tets = moulage.Tetrahedralization(moulage.TriMesh(self.points, self.triangles), "lattice", 300)

    def test_whole_numbers_do_not_wrap(self):
        surface = moulage.TriMesh(self.points, self.triangles)
        for wrong in (-5, 2**32 + 500):
            with self.assertRaisesRegex(ValueError, f"tet_count: {wrong} where"):
                moulage.Tetrahedralization(surface, "lattice", wrong)
        problem = moulage.Reshaping(self.tets)
        problem.set_landmarks_at_vertices(range(8), self.points)
        for name in ("max_iterations", "thread_count"):
            with self.assertRaisesRegex(ValueError, f"{name}: -1 where"):
                problem.start(moulage.ReshapingOptions(**{name: -1}))
        with self.assertRaises(TypeError):
            problem.start(moulage.ReshapingOptions(max_iterations=2.5))
        with self.assertRaisesRegex(moulage.Error, "5000 threads are too many"):
            problem.start(moulage.ReshapingOptions(thread_count=5000))
        apart = moulage.Separation()
        apart.add_body("cube", moulage.TetMesh(self.tets.points, self.tets.tets))
        with self.assertRaisesRegex(ValueError, "-1 where a whole number"):
            apart.set_markers(-1, self.points)

    def test_a_handle_is_neither_copied_nor_pickled(self):
        for wrong in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "a Tetrahedralization cannot be copied or pickled"):
                wrong(self.tets)
        self.assertGreater(len(self.tets.points), 0)

    @unittest.skipUnless(hasattr(os, "fork"), "this system does not fork")
    def test_a_forked_child_is_told_so_and_ends(self):
        child = os.fork()
        if child == 0:
            try:
                moulage.TriMesh(self.points, self.triangles)
            except moulage.LibraryError as error:
                os._exit(7 if "spawn" in str(error) else 1)
            os._exit(2)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 7)

    def test_what_waits_listens_to_ctrl_c_and_ends_its_run(self):
        # A shell that starts the tests in the background has them ignore Ctrl-C.
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, signal.default_int_handler))
        run = long_run()
        interrupt = threading.Thread(target=_interrupt_main_when, args=(lambda: run.poll().iteration > 0,))
        interrupt.start()
        with self.assertRaises(KeyboardInterrupt):
            run.wait()
        interrupt.join()
        # Nobody waits, but the result so far is there.
        self.assertEqual(run.wait().summary["stop"], "cancelled")

    def test_a_with_block_that_is_left_ends_its_run(self):
        with self.assertRaisesRegex(RuntimeError, "mine"), long_run() as run:
            raise RuntimeError("mine")
        while not run.poll().ended:
            time.sleep(0.01)
        self.assertLess(run.poll().fraction, 1)

    def test_a_number_that_is_not_there_is_an_index_error(self):
        bone = moulage.TriMesh(self.points, self.triangles)
        with self.assertRaisesRegex(IndexError, "no number 3"):
            moulage.Skeleton([("bone", bone)]).bone_points(3)


if __name__ == "__main__":
    unittest.main(verbosity=2)

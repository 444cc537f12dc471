"""The optional native kernel: the same numbers as numpy's, in C.

`kernel.c` and the headers that it includes are compiled where there is a compiler (`build.py`: when the
package is built or installed, editable too, or by `python -m fikm_drake.kinematics.native.build` in a
checkout) and loaded by ctypes (`kernel.py`). Without a compiler numpy does the work; the results are the same
to rounding. `FIKM_DRAKE_NATIVE=0` in the environment leaves the kernel out; `fikm-drake --version` says
which one works. `cycle.h` is a control cycle as `control/cycle.py` tells it; what is out of the ordinary in
a cycle it leaves to Python, so that is where a reader reads. May enter: arithmetic that numpy code of this
project also has, over plain arrays.
"""

"""Importing this pins BLAS to one thread: import it before anything that imports numpy.

A matrix of 184 rows gains nothing from a second thread and takes several times as long with it.
"""

import os

for _name in ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS', 'BLIS_NUM_THREADS'):
    os.environ[_name] = '1'

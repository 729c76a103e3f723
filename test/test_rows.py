# Copyright 2026 squeal_ros developers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The tables of cases that other tests are made of: no row is left out, every failure is shown."""

import pytest
from support.rows import each


def test_every_row_is_tried_and_all_that_fail_are_reported() -> None:
    tried = []

    @each(('value', 'limit'), [(1, 2), (3, 2), pytest.param(2, 2, id='two'), (1, 2)])
    @each('sign', [1, -1])
    def check(value: int, limit: int, sign: int, more: str) -> None:
        tried.append((value, sign, more))
        assert sign * value < limit, 'too large'

    with pytest.raises(pytest.fail.Exception, match='2 of 4 rows') as caught:
        check(more='x')
    assert tried == [(v, s, 'x') for v in (1, 3, 2, 1) for s in (1, -1)]
    said = str(caught.value)
    assert 'value=3, limit=2: Failed: 1 of 2 rows\nsign=1: AssertionError: too large' in said
    assert 'value=2, limit=2: Failed' in said
    assert 'value=1' not in said


def test_what_pytest_itself_fails_is_a_failed_row() -> None:
    @each('value', [0, 1])
    def check(value: int) -> None:
        with pytest.raises(ZeroDivisionError):
            assert 1 // value

    with pytest.raises(pytest.fail.Exception, match='1 of 2 rows\nvalue=1: Failed: DID NOT RAISE'):
        check()


@each('name', ['one', 'two'])
def test_fixtures_are_given_beside_a_row(tmp_path: object, name: str) -> None:
    assert tmp_path
    assert name


def test_a_table_without_rows_is_none() -> None:
    with pytest.raises(AssertionError, match='without rows'):
        each('value', [])
